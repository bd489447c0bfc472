// Graphics cards and what hangs on them, through libdrm.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "hal/display/display.h"
#include "hal/display/kms_mode.h"

struct _drmModeConnector;

namespace cupola {

// An open descriptor, closed with its owner.
class KmsFile {
 public:
  explicit KmsFile(int descriptor = -1) : descriptor_(descriptor) {}
  KmsFile(KmsFile&& other) noexcept : descriptor_(other.descriptor_) { other.descriptor_ = -1; }
  KmsFile& operator=(KmsFile&& other) noexcept;
  ~KmsFile();
  int get() const { return descriptor_; }
  explicit operator bool() const { return descriptor_ >= 0; }

 private:
  int descriptor_;
};

// A card as a list of devices shows it.
struct KmsCard {
  std::filesystem::path path;  // "/dev/dri/card0"
  std::string driver;          // "vc4"
  std::vector<KmsConnector> connectors;
  std::string trouble;  // why it cannot be used; empty: it can
};
// Every card, by number. Takes as long as reading the projectors' descriptions does.
std::vector<KmsCard> list_kms_cards(const std::filesystem::path& folder = "/dev/dri");

// The card's file with the capabilities that we need switched on. Throws std::runtime_error.
KmsFile open_kms_card(const std::filesystem::path& path);
std::vector<KmsConnector> connectors_of(const KmsFile& card);
KmsMode mode_of(const _drmModeConnector& connector, int index);

// The parts of the card that together show one picture, with the numbers of the properties that we set.
struct KmsPipe {
  std::uint32_t connector = 0;
  std::uint32_t crtc = 0;
  std::uint32_t plane = 0;                // the primary one
  std::vector<std::uint32_t> neighbours;  // connectors that show this CRTC's picture too: to be let go
  struct {
    std::uint32_t crtc_id, link_status;  // link_status 0: it has none
  } connector_property{};
  struct {
    std::uint32_t mode_id, active;
  } crtc_property{};
  struct {
    std::uint32_t fb_id, crtc_id, src_x, src_y, src_w, src_h, crtc_x, crtc_y, crtc_w, crtc_h;
  } plane_property{};
  // What NV12 is to mean; properties that are 0 are not there.
  struct {
    std::uint32_t encoding, range;
    std::uint64_t encoding_value, range_value;
  } nv12_colour{};
};
// Throws std::runtime_error where no CRTC or plane is left for the connector.
KmsPipe find_kms_pipe(const KmsFile& card, const KmsConnector& connector);
// Whether the pipe's plane takes NV12 of that colour, which is then in `pipe`. Planes that cannot be told
// take BT.601 of limited range.
bool choose_nv12(const KmsFile& card, KmsPipe& pipe, ScanoutColour colour);

// The kernel's own word on whether something is plugged in, which can be read without waiting for anybody.
class KmsPlug {
 public:
  // Without sysfs every connector counts as plugged in.
  KmsPlug(const std::filesystem::path& card, const std::string& connector);
  bool in() const noexcept;

 private:
  KmsFile status_;
};

}  // namespace cupola
