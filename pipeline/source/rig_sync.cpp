// Sets are looked for from the newest frame backwards: a handful of frames, so every one is tried.
// SPDX-License-Identifier: MIT
#include "pipeline/source/rig_sync.h"

#include <algorithm>
#include <cassert>
#include <functional>
#include <utility>

namespace cupola {

using std::chrono::nanoseconds;

namespace {

// An alpha-beta filter's gains: about a second's mean at 60 frames a second, critically damped.
constexpr double kOffsetGain = 1.0 / 16;
constexpr double kDriftGain = kOffsetGain * kOffsetGain / (2.0 - kOffsetGain);

}  // namespace

// The frames nearest to one time.
struct RigSync::Match {
  std::array<int, kMostCameras> member{};  // for each camera the place among those held, or -1
  std::array<bool, kMostCameras> in_step{};
  nanoseconds at{0};
  bool whole = true;  // every camera that has frames is in step
  bool ready = true;  // nothing is waited for any more
};

RigSync::RigSync(std::size_t cameras, const SyncSettings& settings)
    : settings_(settings), cameras_(cameras), faces_(cameras) {
  assert(cameras <= kMostCameras);
  spent_.reserve(cameras * (kHeld + 2));
}

void RigSync::drop(std::size_t camera, std::size_t count) noexcept {
  Queue& queue = cameras_[camera];
  assert(count <= queue.count && spent_.size() + count <= spent_.capacity());
  for (std::size_t i = 0; i < count; ++i) {
    if (!(queue.shown && i == 0)) ++counts_.passed_over;
    spent_.push_back({camera, queue.held[i].frame});
  }
  std::move(queue.held.begin() + static_cast<std::ptrdiff_t>(count),
            queue.held.begin() + static_cast<std::ptrdiff_t>(queue.count), queue.held.begin());
  queue.count -= count;
  if (count > 0) queue.shown = false;
}

void RigSync::offer(std::size_t camera, const CameraFrame& frame, nanoseconds now) noexcept {
  Queue& queue = cameras_[camera];
  if (queue.count == kHeld) {  // nobody has chosen for long: the oldest that is not shown goes
    const std::size_t oldest = queue.shown ? 1 : 0;
    std::rotate(queue.held.begin(), queue.held.begin() + static_cast<std::ptrdiff_t>(oldest),
                queue.held.begin() + static_cast<std::ptrdiff_t>(oldest) + 1);
    const bool shown = std::exchange(queue.shown, false);
    drop(camera, 1);
    queue.shown = shown;
  }
  queue.held[queue.count++] = {frame, now};
}

void RigSync::lose(std::size_t camera, const CameraFrame* kept) noexcept {
  Queue& queue = cameras_[camera];
  queue.count = 0;
  queue.shown = false;
  if (!kept) return;
  queue.held[0] = {*kept, kept->captured_at};
  queue.count = 1;
  queue.shown = true;
  faces_[camera] = {SyncedFace::State::kLate, *kept};
}

RigSync::Match RigSync::match(nanoseconds at, nanoseconds now) const noexcept {
  Match match;
  match.at = at;
  nanoseconds first_came = nanoseconds::max();
  bool waited_for = false;
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    const Queue& queue = cameras_[c];
    match.member[c] = -1;
    nanoseconds nearest = nanoseconds::max();
    for (std::size_t i = 0; i < queue.count; ++i) {
      const nanoseconds apart = std::chrono::abs(queue.held[i].frame.captured_at - at);
      if (apart > nearest) continue;
      nearest = apart;
      match.member[c] = static_cast<int>(i);
    }
    match.in_step[c] = nearest <= settings_.tolerance;
    if (match.in_step[c]) {
      first_came = std::min(first_came, queue.held[static_cast<std::size_t>(match.member[c])].came_at);
    } else if (queue.count > 0) {
      match.whole = false;
      // Who was late before does not hold up the others again.
      waited_for = waited_for || faces_[c].state == SyncedFace::State::kInStep;
    }
  }
  match.ready = !waited_for || now >= first_came + settings_.tolerance;
  return match;
}

void RigSync::show(const Match& match) noexcept {
  nanoseconds first = match.at;
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    Queue& queue = cameras_[c];
    if (match.member[c] < 0) continue;
    drop(c, static_cast<std::size_t>(match.member[c]));
    queue.shown = true;
    const CameraFrame& frame = queue.held[0].frame;
    if (match.in_step[c]) first = std::min(first, frame.captured_at);
    faces_[c] = {match.in_step[c] ? SyncedFace::State::kInStep : SyncedFace::State::kLate, frame};
  }
  set_at_ = first;
  ++counts_.sets;
  if (match.whole) ++counts_.whole;
  measure_offsets();
}

// The newest set that is whole; else the newest that need not wait. A whole set beats a newer one with a
// camera missing: in step counts for more than one frame's age.
bool RigSync::show_newest(nanoseconds now) noexcept {
  std::array<nanoseconds, kMostCameras * kHeld> times{};
  std::size_t count = 0;
  for (const Queue& queue : cameras_) {
    for (std::size_t i = queue.shown ? 1 : 0; i < queue.count; ++i) {
      times[count++] = queue.held[i].frame.captured_at;
    }
  }
  std::sort(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(count), std::greater<>());
  for (const bool want_whole : {true, false}) {
    for (std::size_t i = 0; i < count; ++i) {
      const Match found = match(times[i], now);
      if (want_whole ? found.whole : found.ready) {
        show(found);
        return true;
      }
    }
  }
  return false;
}

bool RigSync::choose(nanoseconds now) noexcept {
  bool changed = show_newest(now);
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    Queue& queue = cameras_[c];
    if (queue.shown && now - queue.held[0].frame.captured_at > settings_.patience) drop(c, 1);
    if (queue.shown || faces_[c].state == SyncedFace::State::kSlate) continue;
    faces_[c] = {};
    changed = true;
  }
  return changed;
}

std::optional<RigSync::Spent> RigSync::spent() noexcept {
  if (spent_.empty()) return {};
  const Spent frame = spent_.back();
  spent_.pop_back();
  return frame;
}

void RigSync::measure_offsets() noexcept {
  if (faces_[0].state != SyncedFace::State::kInStep) return;
  const nanoseconds first = faces_[0].frame.captured_at;
  for (std::size_t c = 1; c < cameras_.size(); ++c) {
    if (faces_[c].state == SyncedFace::State::kInStep) {
      cameras_[c].clock.measure(first, faces_[c].frame.captured_at - first);
    }
  }
}

void RigSync::OffsetFilter::measure(nanoseconds at, nanoseconds apart) noexcept {
  const double elapsed = static_cast<double>((at - measured_at).count());
  measured_at = at;
  if (!begun) {
    begun = true;
    offset = static_cast<double>(apart.count());
    return;
  }
  if (elapsed <= 0.0) return;
  const double predicted = offset + drift * elapsed;
  const double error = static_cast<double>(apart.count()) - predicted;
  offset = predicted + kOffsetGain * error;
  drift += kDriftGain * error / elapsed;
}

SyncOffset RigSync::offset(std::size_t camera) const {
  const OffsetFilter& clock = cameras_[camera].clock;
  return {nanoseconds(static_cast<std::int64_t>(clock.offset)), 1e6 * clock.drift};
}

}  // namespace cupola
