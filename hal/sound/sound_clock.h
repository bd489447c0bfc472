// When a frame of sound is heard: a line through what the device says, which jitters and counts in blocks.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>

namespace cupola {

// Frames heard against the clock's time: the line that fits best while it is young (least squares, with the
// rate held near its nominal one at first), later one that forgets what is older than about half a minute.
class SoundClock {
 public:
  explicit SoundClock(int rate) : rate_(rate) {}

  // `frames` were heard at `at`, which rises from call to call.
  void note(std::int64_t frames, std::chrono::nanoseconds at) noexcept;
  // The stream has stood still: frames begin anew, the crystal is the same.
  void begin_anew() noexcept { noted_ = 0; }

  bool knows() const noexcept { return noted_ > 0; }
  double heard_at(std::chrono::nanoseconds at) const noexcept;    // frames
  std::chrono::nanoseconds time_of(double frame) const noexcept;  // when it is heard
  double ppm() const noexcept { return 1e6 * faster_; }           // by which the device is too fast

 private:
  int rate_;
  std::int64_t noted_ = 0;  // since the stream began
  std::int64_t noted_ever_ = 0;
  double frames_ = 0.0;             // heard ...
  std::chrono::nanoseconds at_{0};  // ... at
  double faster_ = 0.0;             // than rate_, a fraction
};

}  // namespace cupola
