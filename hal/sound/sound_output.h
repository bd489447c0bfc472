// Where sound goes: a stream of frames, and how much of it has been heard at a time of the clock.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

namespace cupola {

struct SoundMode {
  int rate = 48000;  // frames a second
  int channels = 2;  // samples a frame, in the order of WAV files: front left, right, centre, low, back ...
  friend bool operator==(const SoundMode&, const SoundMode&) = default;
};

// Of the frames written since open().
struct SoundHeard {
  std::int64_t frames = 0;         // that have left the loudspeakers, as far as the driver knows ...
  std::chrono::nanoseconds at{0};  // ... by then, of the clock
  std::int64_t queued = 0;         // of those that have not: what it still has to take from its buffer
  std::int64_t underruns = 0;      // times that it had nothing left to play; the next write() goes on
};

// One thread. Nothing here throws, and nothing but open() waits.
class SoundOutput {
 public:
  virtual ~SoundOutput() = default;
  // Opens it anew, at about `wanted`; gives what it got, or nothing and trouble().
  virtual std::optional<SoundMode> open(const SoundMode& wanted) noexcept = 0;
  // Interleaved samples of whole frames, from -1 to 1; takes as many frames as there is room for and says how
  // many. None: the device is lost, until it is opened again. The first ones begin the stream.
  virtual std::optional<std::int64_t> write(std::span<const float> samples) noexcept = 0;
  // None: the device is lost.
  virtual std::optional<SoundHeard> heard() noexcept = 0;
  // In words, why it could not be opened or was lost; valid until the next call.
  virtual const char* trouble() const noexcept = 0;
};

}  // namespace cupola
