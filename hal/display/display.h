// The projector's side of the frame loop: somewhere to draw the next frame, and the moment it was shown.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace cupola {

// Pixels to fill: little-endian 32-bit words 0xffRRGGBB. Borrowed until the next present().
struct DisplayBuffer {
  std::byte* data = nullptr;
  std::ptrdiff_t stride = 0;  // bytes
  int width = 0;              // pixels
  int height = 0;
  int age = 0;  // it holds what was presented this many presents ago, 1 being the last; 0: anything
};

enum class Present : std::uint8_t {
  kShown,   // `flipped_at` is the time it reached the screen
  kClosed,  // the operator closed it: the show ends
  kLost,    // the display went away or refused the frame
};

struct Presented {
  Present result = Present::kShown;
  std::chrono::nanoseconds flipped_at{0};  // CLOCK_MONOTONIC
};

class Display {
 public:
  virtual ~Display() = default;
  // The buffer for the next frame; its old contents are what `age` says.
  virtual DisplayBuffer back_buffer() noexcept = 0;
  // Shows the back buffer at the first flip at or after `when`. Returns after the flip.
  virtual Presented present(std::chrono::nanoseconds when) noexcept = 0;
  // The same for the frame that is shown already, once more; only after a present().
  virtual Presented repeat(std::chrono::nanoseconds when) noexcept = 0;
  // Time between flips; 0 when the display takes frames at any time.
  virtual std::chrono::nanoseconds period() const noexcept = 0;
};

}  // namespace cupola
