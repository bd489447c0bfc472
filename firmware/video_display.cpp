// One buffer, written where it stands.
// SPDX-License-Identifier: MIT
#include "firmware/video_display.h"

#include <exception>

namespace cupola {

VideoDisplay::VideoDisplay(Clock& clock, const std::filesystem::path& path, Size size, double rate)
    : clock_(clock), video_(path, size, frame_rate(rate)), frame_(PixelFormat::kXrgb8888, size) {}

DisplayBuffer VideoDisplay::back_buffer() noexcept {
  const MutableImage& pixels = frame_.pixels();
  return {pixels.planes[0].data, pixels.planes[0].stride, pixels.size.width, pixels.size.height};
}

Presented VideoDisplay::present(std::chrono::nanoseconds when) noexcept {
  try {
    video_.write(as_const(frame_.pixels()));
  } catch (const std::exception& error) {
    trouble_ = error.what();
    return {Present::kLost, clock_.now()};
  }
  clock_.sleep_until(when);
  return {Present::kShown, clock_.now()};
}

}  // namespace cupola
