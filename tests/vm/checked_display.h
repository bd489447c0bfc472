// A display on vkms whose screen is read back and compared with the scalar warp of the buffers that it shows.
// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "firmware/live_frames.h"
#include "hal/display/display.h"
#include "tests/vm/vkms_screen.h"

namespace cupola {

class CheckedDisplay final : public Display {
 public:
  // Looks at one flip of `every` that show a new picture; `flipped` is called after each, with how many there
  // were before. All are borrowed.
  CheckedDisplay(Display& display, const LiveFrames& live, WorkerPool& pool, int every = 1,
                 std::function<void(int)> flipped = {})
      : display_(display),
        live_(live),
        warp_(make_native_to_xrgb_warp(live.rig(), NativeLayout::kNv12, Cpu::kScalar, pool)),
        expected_(PixelFormat::kXrgb8888, live.rig().frame.size),
        nv12_warp_(live.nv12_colour() ? make_nv12_warp(live.rig(), NativeLayout::kNv12, Cpu::kScalar, pool)
                                      : nullptr),
        nv12_expected_(NativeLayout::kNv12, live.nv12_colour().value_or(YuvColour{}), live.rig().frame.size),
        every_(every),
        flipped_(std::move(flipped)) {}
  DisplayBuffer back_buffer() noexcept override {
    is_nv12_ = false;
    return display_.back_buffer();
  }
  bool prepare_nv12(ScanoutColour colour) override { return display_.prepare_nv12(colour); }
  DisplayBuffer back_nv12() noexcept override {
    is_nv12_ = true;
    return display_.back_nv12();
  }
  Presented present(std::chrono::nanoseconds when) noexcept override {
    const Presented presented = display_.present(when);
    if (presented.result == Present::kShown && presents_++ % every_ == 0) compare();
    if (flipped_) flipped_(flips_++);
    return presented;
  }
  Presented repeat(std::chrono::nanoseconds when) noexcept override {
    const Presented presented = display_.repeat(when);
    if (flipped_) flipped_(flips_++);
    return presented;
  }
  std::chrono::nanoseconds period() const noexcept override { return display_.period(); }
  const char* trouble() const noexcept override { return display_.trouble(); }

  int compared() const { return compared_; }
  int in_nv12() const { return in_nv12_; }  // of the compared
  long wrong() const { return wrong_; }     // pixels
  long bright() const { return bright_; }   // pixels: something is seen

 private:
  void compare() {
    const Size size = expected_.size();
    if (is_nv12_) {
      nv12_warp_->warp(live_.faces().faces(), nv12_expected_.pixels());
    } else {
      warp_->warp(live_.faces().faces(), expected_.pixels());
    }
    const std::vector<std::uint32_t> screen = vkms_screen(size.width, size.height);
    ASSERT_EQ(screen.size(), static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
    const std::uint32_t* shown = screen.data();
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x, ++shown) {
        wrong_ += is_nv12_ ? !near_nv12(*shown, x, y) : !is_xrgb(*shown, x, y);
        bright_ += (*shown & 0xffU) > 60U || (*shown >> 8U & 0xffU) > 60U || (*shown >> 16U & 0xffU) > 60U;
      }
    }
    ++compared_;
    in_nv12_ += is_nv12_ ? 1 : 0;
  }
  bool is_xrgb(std::uint32_t shown, int x, int y) {
    return (shown & 0xffffffU) == (expected_.pixels().samples<std::uint32_t>(0, y)[x] & 0xffffffU);
  }
  // Within the rounding of the driver's conversion.
  bool near_nv12(std::uint32_t shown, int x, int y) {
    const MutableNativeImage& frame = nv12_expected_.pixels();
    const auto rgb = rgb_of(frame.colour, *sample_at(frame, 0, x, y), *sample_at(frame, 1, x / 2, y / 2),
                            *sample_at(frame, 2, x / 2, y / 2));
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = shown >> (16 - 8 * c) & 255U;
      if (std::abs(value - std::clamp(rgb[c], 0.0, 255.0)) > 0.51) return false;
    }
    return true;
  }

  Display& display_;
  const LiveFrames& live_;
  std::unique_ptr<NativeWarp<MutableImage>> warp_;
  ImageBuffer expected_;
  std::unique_ptr<NativeWarp<MutableNativeImage>> nv12_warp_;  // null: it makes none
  NativeBuffer nv12_expected_;
  bool is_nv12_ = false;  // the frame to be presented next, or that stands
  const int every_;
  const std::function<void(int)> flipped_;
  int presents_ = 0;
  int flips_ = 0;
  int compared_ = 0;
  int in_nv12_ = 0;
  long wrong_ = 0;
  long bright_ = 0;
};

}  // namespace cupola
