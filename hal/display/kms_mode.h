// Which connector and which of its modes the projector gets: choices that need no device.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cupola {

struct KmsMode {
  int width = 0;  // pixels
  int height = 0;
  std::chrono::nanoseconds period{0};  // between flips
  bool preferred = false;              // by the projector: its own raster
  bool progressive = true;             // neither interlaced nor with doubled lines
};

struct KmsConnector {
  std::string name;  // as the kernel calls it: "HDMI-A-1"
  std::uint32_t id = 0;
  bool connected = false;
  std::vector<KmsMode> modes;  // none while disconnected
};

// Zeros: whatever the projector prefers, or at that size the highest rate.
struct KmsModeWish {
  int width = 0;
  int height = 0;
  double rate = 0.0;  // flips a second; a mode within half a one is taken for it
};
// "1920x1200@60", "1920x1200", or "" for the preferred one; nothing where the text is none of these.
std::optional<KmsModeWish> parse_kms_mode(std::string_view text);

enum class KmsModeTrouble : std::uint8_t { kNone, kNoModes, kNoSuchMode, kFrameLarger };
struct KmsModeChoice {
  std::size_t index = 0;  // into `modes`: the chosen one, or with kFrameLarger the one that is too small
  KmsModeTrouble trouble = KmsModeTrouble::kNone;
};
// The mode for frames of that size, which are shown one to one in its middle. Allocates nothing.
KmsModeChoice choose_kms_mode(std::span<const KmsMode> modes, const KmsModeWish& wish, int frame_width,
                              int frame_height) noexcept;
// "HDMI-A-1 has no mode 1920x1200@60; it has 1024x768@60.00, ..."
std::string describe(const KmsModeChoice& choice, const KmsConnector& connector, const KmsModeWish& wish,
                     int frame_width, int frame_height);

// The connector of that name, or the first that is connected where `name` is empty.
std::optional<std::size_t> choose_kms_connector(std::span<const KmsConnector> connectors,
                                                std::string_view name) noexcept;

// "1920x1200@59.95"
std::string name_of(const KmsMode& mode);

}  // namespace cupola
