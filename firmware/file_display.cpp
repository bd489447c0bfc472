// One buffer, written where it stands.
// SPDX-License-Identifier: MIT
#include "firmware/file_display.h"

#include <exception>
#include <utility>

namespace cupola {

FileDisplay::FileDisplay(Clock& clock, Size size, std::function<void(const Image&)> write)
    : clock_(clock), write_(std::move(write)), frame_(PixelFormat::kXrgb8888, size) {}

DisplayBuffer FileDisplay::back_buffer() noexcept {
  const MutableImage& pixels = frame_.pixels();
  return {pixels.planes[0].data, pixels.planes[0].stride, pixels.size.width, pixels.size.height,
          presented_ ? 1 : 0};
}

Presented FileDisplay::present(std::chrono::nanoseconds when) noexcept {
  try {
    write_(as_const(frame_.pixels()));
  } catch (const std::exception& error) {
    trouble_ = error.what();
    return {Present::kLost, clock_.now()};
  }
  presented_ = true;
  clock_.sleep_until(when);
  return {Present::kShown, clock_.now()};
}

}  // namespace cupola
