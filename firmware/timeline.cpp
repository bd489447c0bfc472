// Cues one after the other.
// SPDX-License-Identifier: MIT
#include "firmware/timeline.h"

#include <algorithm>
#include <cmath>

namespace cupola {

using std::chrono::nanoseconds;

Timeline::Timeline(std::vector<CueTiming> cues) : cues_(std::move(cues)) {
  for (const CueTiming& cue : cues_) lengths_.push_back(length_of(cue));
}

// A quarter of a flip at 60 Hz: what jitter may do, however long a cue's frames last.
constexpr nanoseconds kMostEarly{4'000'000};

std::optional<nanoseconds> Timeline::length_of(const CueTiming& cue) const {
  std::optional<nanoseconds> length = cue.duration;
  if (!length && cue.frames && !cue.loop) {
    length = nanoseconds(std::llround(1e9 * static_cast<double>(*cue.frames) / cue.rate));
  }
  if (length) length = std::max(*length, nanoseconds(1));
  return length;
}

std::optional<Moment> Timeline::at(nanoseconds time) noexcept {
  while (!over_) {
    const CueTiming& cue = cues_[cue_];
    const nanoseconds early = std::min(kMostEarly, nanoseconds(std::llround(0.25e9 / cue.rate)));
    const nanoseconds within = time - begin_ + early;
    if (!lengths_[cue_] || within < *lengths_[cue_]) {
      std::int64_t frame = static_cast<std::int64_t>(
          static_cast<double>(std::max<std::int64_t>(0, within.count())) * cue.rate * 1e-9);
      if (cue.frames) frame = cue.loop ? frame % *cue.frames : std::min(frame, *cue.frames - 1);
      return Moment{cue_, cue.first + frame};
    }
    begin_ += *lengths_[cue_];
    over_ = !cue.then;
    cue_ = cue.then.value_or(cue_);
  }
  return std::nullopt;
}

void Timeline::next_cue(nanoseconds time) noexcept {
  if (over_ || !cues_[cue_].then) return;
  begin_ = time;
  cue_ = *cues_[cue_].then;
}

std::optional<nanoseconds> Timeline::length() const {
  nanoseconds sum{0};
  std::vector<bool> seen(cues_.size());
  for (std::size_t cue = 0;;) {
    if (seen[cue] || !lengths_[cue]) return std::nullopt;
    seen[cue] = true;
    sum += *lengths_[cue];
    if (!cues_[cue].then) return sum;
    cue = *cues_[cue].then;
  }
}

}  // namespace cupola
