// The projector's side of the frame loop: somewhere to draw the next frame, and the moment it was shown.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace cupola {

// Pixels to fill: little-endian 32-bit words 0xffRRGGBB, or, where there is `chroma`, NV12. Borrowed until
// the next present() or repeat().
struct DisplayBuffer {
  std::byte* data = nullptr;
  std::ptrdiff_t stride = 0;  // bytes
  int width = 0;              // pixels
  int height = 0;
  int age = 0;  // it holds what was presented this many presents ago, 1 being the last; 0: anything
  std::byte* chroma = nullptr;  // bytes U V U V ..., half the rows, rounded up, and the same stride
};

// What NV12 means to a screen.
struct ScanoutColour {
  bool bt709 = false;  // else BT.601
  bool full_range = false;
};

enum class Present : std::uint8_t {
  kShown,   // `flipped_at` is the time it reached the screen
  kClosed,  // the operator closed it: the show ends
  kAway,    // not shown, the screen is away for now: `flipped_at` is when it would have been, or when it
            // was clear that it was not; the frame counts as presented, for `age` and for repeat()
  kLost,    // the display is gone for good
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
  // Before the first frame: makes ready for frames of NV12 in place of some. False: it takes none.
  virtual bool prepare_nv12(ScanoutColour /*colour*/) { return false; }
  // Where it is ready for them, the buffer for the next frame in place of back_buffer()'s.
  virtual DisplayBuffer back_nv12() noexcept { return {}; }
  // Shows the back buffer, the one asked for last, at the first flip at or after `when`; one up to a
  // sixteenth of a period early is at it. Returns after the flip.
  virtual Presented present(std::chrono::nanoseconds when) noexcept = 0;
  // The same for the frame that was presented last, once more; only after a present().
  virtual Presented repeat(std::chrono::nanoseconds when) noexcept = 0;
  // Time between flips; 0 when the display takes frames at any time. Another screen may come back than went.
  virtual std::chrono::nanoseconds period() const noexcept = 0;
  // In words, why the last present() or repeat() was kAway or kLost; valid until the next one.
  virtual const char* trouble() const noexcept = 0;
};

}  // namespace cupola
