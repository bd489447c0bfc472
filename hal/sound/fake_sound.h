// A sound card of memory on the given clock, whose crystal, buffers and cable do what a test wants.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hal/sound/sound_output.h"
#include "hal/time/clock.h"

namespace cupola {

struct FakeSoundFaults {
  double ppm = 0.0;                     // by which its crystal is too fast
  std::int64_t grain = 1;               // frames: heard() counts in whole ones of these, as drivers do
  std::chrono::nanoseconds jitter{0};   // heard() is wrong by at most so much, another amount each time
  std::chrono::nanoseconds latency{0};  // from its buffer to the ear
  std::int64_t most_a_write = 1 << 20;  // frames
  struct Absence {
    std::chrono::nanoseconds from;
    std::chrono::nanoseconds until;
  };
  std::vector<Absence> absences = {};  // lost, and not to be opened; one after the other
  // Times at which what is buffered is gone, as when the machine slept too long.
  std::vector<std::chrono::nanoseconds> underruns = {};
};

class FakeSound final : public SoundOutput {
 public:
  // `clock` is borrowed for the card's life. It has `mode` whatever is wanted, and a buffer of 0.2 s.
  FakeSound(Clock& clock, const SoundMode& mode, FakeSoundFaults faults = {});

  std::optional<SoundMode> open(const SoundMode& wanted) noexcept override;
  std::optional<std::int64_t> write(std::span<const float> samples) noexcept override;
  std::optional<SoundHeard> heard() noexcept override;
  const char* trouble() const noexcept override { return trouble_; }

  // The sample of `channel` that is heard now; 0 where nothing is.
  float sounding(int channel = 0) noexcept;
  std::int64_t opens() const { return opens_; }
  std::int64_t buffered() noexcept;  // frames written and not played

 private:
  bool away() noexcept;
  // To the clock's time.
  void play_on() noexcept;

  Clock& clock_;
  const SoundMode mode_;
  FakeSoundFaults faults_;
  const std::int64_t room_;
  std::vector<float> memory_;  // a ring of the last frames written
  bool open_ = false;
  bool running_ = false;
  std::int64_t written_ = 0;
  double played_ = 0.0;                    // frames
  std::chrono::nanoseconds played_at_{0};  // of the clock: when it was so many
  std::int64_t underruns_ = 0;
  std::size_t next_underrun_ = 0;
  std::size_t next_absence_ = 0;
  std::uint64_t chance_ = 88172645463325252U;
  std::int64_t opens_ = 0;
  const char* trouble_ = "";
};

}  // namespace cupola
