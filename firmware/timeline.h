// Which frame of which cue is due at a time of the show.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace cupola {

struct CueTiming {
  double rate = 60.0;                                 // frames a second, > 0
  std::int64_t first = 0;                             // the source's frame to begin with
  std::optional<std::int64_t> frames = std::nullopt;  // from there; none when the source never ends
  bool loop = false;                                  // begin again after the last; else it stands
  std::optional<std::chrono::nanoseconds> duration =
      std::nullopt;                                // none: until the last frame is over, or for ever
  std::optional<std::size_t> then = std::nullopt;  // the next cue; none: the show stops
};

struct Moment {
  std::size_t cue = 0;
  std::int64_t frame = 0;  // of the cue's source
  friend bool operator==(const Moment&, const Moment&) = default;
};

// Times are nanoseconds from the show's start. A frame is due a quarter of its length early, 4 ms at most, so
// that flips that jitter about their times do not skip or repeat one.
class Timeline {
 public:
  explicit Timeline(std::vector<CueTiming> cues);  // at least one

  // Time must not run backwards from call to call; none when the show is over. Does not allocate.
  std::optional<Moment> at(std::chrono::nanoseconds time) noexcept;
  // The cue that follows begins at `time`, which must not run backwards either; after the last one nothing
  // follows.
  void next_cue(std::chrono::nanoseconds time) noexcept;
  // How long the show is; none when it never ends.
  std::optional<std::chrono::nanoseconds> length() const;

 private:
  std::optional<std::chrono::nanoseconds> length_of(const CueTiming& cue) const;

  std::vector<CueTiming> cues_;
  std::vector<std::optional<std::chrono::nanoseconds>> lengths_;
  std::size_t cue_ = 0;
  std::chrono::nanoseconds begin_{0};  // of the cue
  bool over_ = false;
};

}  // namespace cupola
