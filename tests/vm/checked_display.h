// A display on vkms whose screen is read back and compared with the scalar warp of the buffers that it shows.
// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

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
        every_(every),
        flipped_(std::move(flipped)) {}
  DisplayBuffer back_buffer() noexcept override { return display_.back_buffer(); }
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
  long wrong() const { return wrong_; }    // pixels
  long bright() const { return bright_; }  // pixels: something is seen

 private:
  void compare() {
    const Size size = expected_.size();
    warp_->warp(live_.faces().faces(), expected_.pixels());
    const std::vector<std::uint32_t> screen = vkms_screen(size.width, size.height);
    ASSERT_EQ(screen.size(), static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
    const std::uint32_t* shown = screen.data();
    for (int y = 0; y < size.height; ++y) {
      const auto* row = expected_.pixels().samples<std::uint32_t>(0, y);
      for (int x = 0; x < size.width; ++x, ++shown) {
        wrong_ += (*shown & 0xffffffU) != (row[x] & 0xffffffU);
        bright_ += (*shown & 0xffU) > 60U || (*shown >> 8U & 0xffU) > 60U || (*shown >> 16U & 0xffU) > 60U;
      }
    }
    ++compared_;
  }

  Display& display_;
  const LiveFrames& live_;
  std::unique_ptr<NativeWarp<MutableImage>> warp_;
  ImageBuffer expected_;
  const int every_;
  const std::function<void(int)> flipped_;
  int presents_ = 0;
  int flips_ = 0;
  int compared_ = 0;
  long wrong_ = 0;
  long bright_ = 0;
};

}  // namespace cupola
