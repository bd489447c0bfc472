// Cues one after the other.
// SPDX-License-Identifier: MIT
#include "firmware/timeline.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "firmware/frame_mix.h"

namespace cupola {

using std::chrono::nanoseconds;

Timeline::Timeline(std::vector<CueTiming> cues) : cues_(std::move(cues)) {
  for (const CueTiming& cue : cues_) lengths_.push_back(length_of(cue));
}

namespace {

// A quarter of a flip at 60 Hz: what jitter may do, however long a cue's frames last.
constexpr nanoseconds kMostEarly{4'000'000};

nanoseconds early(const CueTiming& cue) {
  return std::min(kMostEarly, nanoseconds(std::llround(0.25e9 / cue.rate)));
}

}  // namespace

std::optional<nanoseconds> Timeline::length_of(const CueTiming& cue) const {
  std::optional<nanoseconds> length = cue.duration;
  if (!length && cue.frames && !cue.loop) {
    length = nanoseconds(std::llround(1e9 * static_cast<double>(*cue.frames) / cue.rate));
  }
  if (length) length = std::max(*length, nanoseconds(1));
  return length;
}

std::int64_t Timeline::steps(const CueTiming& cue, nanoseconds within) {
  return static_cast<std::int64_t>(static_cast<double>(std::max<std::int64_t>(0, within.count())) * cue.rate *
                                   1e-9);
}

Moment Timeline::moment(std::size_t index, std::int64_t step) const {
  const CueTiming& cue = cues_[index];
  if (cue.frames) step = cue.loop ? step % *cue.frames : std::min(step, *cue.frames - 1);
  return {index, cue.first + step};
}

std::optional<Fade> Timeline::fade_at(std::int64_t step, nanoseconds time) const {
  const std::int64_t frames = cues_[cue_].fade_frames;
  if (!fades_ || step >= frames || (from_ && from_->cue == cue_)) return std::nullopt;
  Fade fade;
  // Never all of one of them: a fade of one frame shows both alike.
  fade.weight = static_cast<std::int32_t>(
      std::lround(kWholeWeight * static_cast<double>(step + 1) / static_cast<double>(frames + 1)));
  if (from_) {
    const CueTiming& old = cues_[from_->cue];
    nanoseconds within = time - from_->begin + early(old);
    if (from_->waited) within = std::min(within, *lengths_[from_->cue] - nanoseconds(1));
    fade.from = moment(from_->cue, steps(old, within));
  }
  return fade;
}

std::optional<Moment> Timeline::at(nanoseconds time) noexcept {
  while (!over_) {
    const CueTiming& cue = cues_[cue_];
    nanoseconds within = time - begin_ + early(cue);
    const bool ended = lengths_[cue_] && within >= *lengths_[cue_];
    waiting_ = ended && cue.wait;
    if (waiting_) within = *lengths_[cue_] - nanoseconds(1);
    if (!ended || waiting_) {
      const std::int64_t step = steps(cue, within);
      fade_ = fade_at(step, time);
      return moment(cue_, step);
    }
    from_ = From{cue_, begin_, false};
    fades_ = true;
    begin_ += *lengths_[cue_];
    over_ = !cue.then;
    cue_ = cue.then.value_or(cue_);
  }
  return std::nullopt;
}

void Timeline::next_cue(nanoseconds time) noexcept {
  if (cues_[cue_].then) jump(*cues_[cue_].then, time);
}

void Timeline::previous_cue(nanoseconds time) noexcept {
  jump(cue_ > 0 ? cue_ - 1 : 0, time);
}

void Timeline::go(nanoseconds time) noexcept {
  if (waiting_ || (cues_[cue_].wait && !lengths_[cue_])) next_cue(time);
}

void Timeline::jump(std::size_t cue, nanoseconds time) noexcept {
  assert(cue < cues_.size());
  if (over_) return;
  from_ = From{cue_, begin_, waiting_};
  fades_ = true;
  cue_ = cue;
  begin_ = time;
  waiting_ = false;
}

void Timeline::seek(nanoseconds position, nanoseconds time) noexcept {
  if (over_) return;
  position = std::max(position, nanoseconds(0));
  if (lengths_[cue_]) position = std::min(position, *lengths_[cue_]);
  begin_ = time - position;
  fades_ = false;
  waiting_ = false;
}

void Timeline::begin_in(std::size_t cue, nanoseconds played) noexcept {
  assert(cue < cues_.size());
  cue_ = cue;
  begin_ = -played;
  fades_ = false;
}

nanoseconds Timeline::position(nanoseconds time) const noexcept {
  const nanoseconds played = std::max(time - begin_, nanoseconds(0));
  return lengths_[cue_] ? std::min(played, *lengths_[cue_]) : played;
}

std::optional<Timeline::Place> Timeline::ahead(Place place, nanoseconds by) const noexcept {
  place.position = std::max(place.position + by, nanoseconds(0));
  // Bounded, should somebody loop cues of a nanosecond.
  for (std::size_t turn = 0; turn <= cues_.size(); ++turn) {
    const std::optional<nanoseconds>& length = lengths_[place.cue];
    if (!length || place.position < *length) return place;
    const CueTiming& cue = cues_[place.cue];
    if (cue.wait || !cue.then) return std::nullopt;
    place.position -= *length;
    place.cue = *cue.then;
  }
  return std::nullopt;
}

std::optional<nanoseconds> Timeline::length() const {
  nanoseconds sum{0};
  std::vector<bool> seen(cues_.size());
  for (std::size_t cue = 0;;) {
    if (seen[cue] || !lengths_[cue] || cues_[cue].wait) return std::nullopt;
    seen[cue] = true;
    sum += *lengths_[cue];
    if (!cues_[cue].then) return sum;
    cue = *cues_[cue].then;
  }
}

void obey(Timeline& timeline, const PlayerCommand& command, nanoseconds time) noexcept {
  switch (command.action) {
    case PlayerAction::kGo:
      return timeline.go(time);
    case PlayerAction::kNext:
      return timeline.next_cue(time);
    case PlayerAction::kPrevious:
      return timeline.previous_cue(time);
    case PlayerAction::kCue:
      if (command.cue < timeline.cues()) timeline.jump(command.cue, time);
      return;
    case PlayerAction::kSeek:
      return timeline.seek(command.position, time);
    default:
      return;
  }
}

}  // namespace cupola
