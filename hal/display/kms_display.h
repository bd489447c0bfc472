// A projector without a desktop: the kernel's mode setting, one flip a frame.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "hal/display/display.h"
#include "hal/display/kms_buffer.h"
#include "hal/display/kms_device.h"
#include "hal/display/kms_mode.h"
#include "hal/display/scanout_turns.h"
#include "hal/time/clock.h"

namespace cupola {

enum class KmsMemoryKind : std::uint8_t { kDumb, kGbm };

struct KmsSettings {
  std::string connector;  // "HDMI-A-1"; empty: the first that has a projector
  KmsModeWish mode;
  std::string card;  // "/dev/dri/card1"; empty: the first that has the connector
  KmsMemoryKind memory = KmsMemoryKind::kDumb;
};

// The frame one to one in the middle of the mode, to the nearest even pixel above and to the left; black
// around it.
class KmsDisplay final : public Display {
 public:
  // Throws std::runtime_error where there is no such connector or mode, or the frame does not fit. A
  // connector that is named may have nothing plugged in: the display is away until it has. `clock` is
  // borrowed for the display's life, and goes by CLOCK_MONOTONIC.
  KmsDisplay(Clock& clock, const KmsSettings& settings, int width, int height);
  ~KmsDisplay() override;
  KmsDisplay(const KmsDisplay&) = delete;
  KmsDisplay& operator=(const KmsDisplay&) = delete;

  DisplayBuffer back_buffer() noexcept override { return back(false); }
  bool prepare_nv12(ScanoutColour colour) override;
  DisplayBuffer back_nv12() noexcept override { return nv12_able_ ? back(true) : DisplayBuffer{}; }
  Presented present(std::chrono::nanoseconds when) noexcept override;
  Presented repeat(std::chrono::nanoseconds when) noexcept override;
  std::chrono::nanoseconds period() const noexcept override { return period_; }
  const char* trouble() const noexcept override { return trouble_.data(); }

  // "HDMI-A-1 at 1920x1200@59.95 on /dev/dri/card0"
  const std::string& description() const { return description_; }

 private:
  void open(const KmsSettings& settings);
  void start(const KmsConnector& connector);
  KmsBuffer& buffer(int turn) noexcept;
  DisplayBuffer back(bool nv12) noexcept;
  DisplayBuffer frame_in(const KmsBuffer& buffer) const;
  void copy_frame(const KmsBuffer& from, const KmsBuffer& to) const noexcept;
  int make(KmsBuffer& buffer, bool nv12, int width, int height) noexcept;
  int make_buffers(int width, int height) noexcept;
  int resize_buffers(int width, int height) noexcept;
  bool find_mode() noexcept;
  int hand_over() noexcept;
  void switch_off() noexcept;
  bool wait_for_flip(std::chrono::nanoseconds deadline) noexcept;
  bool show_last(std::chrono::nanoseconds flip) noexcept;
  bool fail(int error, const char* step) noexcept;
  bool fail(const char* why) noexcept;

  Clock& clock_;
  int width_;  // of the frame
  int height_;
  KmsModeWish wish_;
  std::string connector_;
  std::string description_;
  KmsFile card_;
  KmsPipe pipe_;
  std::unique_ptr<KmsPlug> plug_;
  std::unique_ptr<KmsMemory> memory_;
  std::array<KmsBuffer, ScanoutTurns::kBuffers> buffers_;
  std::array<KmsBuffer, ScanoutTurns::kBuffers> nv12_buffers_;  // where the display takes NV12,
  std::array<bool, ScanoutTurns::kBuffers> is_nv12_{};          // and whether these take the others' turns
  bool nv12_able_ = false;
  std::uint8_t nv12_black_ = 16;  // luma
  ScanoutTurns turns_;
  std::uint32_t mode_blob_ = 0;
  std::chrono::nanoseconds period_{std::chrono::nanoseconds(std::chrono::seconds(1)) / 60};
  std::chrono::nanoseconds last_flip_{0};    // or when it would have been
  std::chrono::nanoseconds next_search_{0};  // for a mode, while there is none
  std::uint64_t flips_ = 0;                  // number of the last one handed over,
  std::chrono::nanoseconds handed_over_{0};  // and when that was
  bool mode_known_ = false;                  // `mode_blob_` is one that the screen has, as far as we know
  bool on_ = false;                          // the screen shows our picture
  bool gone_ = false;                        // the card is
  std::array<char, 160> trouble_{};
};

}  // namespace cupola
