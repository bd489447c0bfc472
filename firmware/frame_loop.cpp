// Pacing: each frame is made for the flip it will be seen at.
// SPDX-License-Identifier: MIT
#include "firmware/frame_loop.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "firmware/heap_count.h"
#include "firmware/interrupt.h"

namespace cupola {

using std::chrono::nanoseconds;

namespace {

MutableImage image_of(const DisplayBuffer& buffer) {
  return {PixelFormat::kXrgb8888, {buffer.width, buffer.height}, {{{buffer.data, buffer.stride}, {}, {}}}};
}

}  // namespace

FrameLoop::FrameLoop(FrameMaker& show, Display& display, Clock& clock, WorkerPool& pool)
    : show_(show),
      display_(display),
      clock_(clock),
      pool_(pool),
      period_(display.period()),
      warp_times_(65536) {
  if (period_ <= nanoseconds(0)) period_ = nanoseconds(std::llround(1e9 / show.rate()));
}

LoopEnd FrameLoop::run(std::optional<nanoseconds> time) noexcept {
  join_frame_loop(pool_);
  const HeapAllocations before = heap_allocations();
  const LoopEnd end = play(time);
  const HeapAllocations after = heap_allocations();
  leave_frame_loop();
  counts_.heap_allocations = after.frame_loop - before.frame_loop;
  counts_.heap_allocations_elsewhere = after.elsewhere - before.elsewhere;
  return end;
}

LoopEnd FrameLoop::play(std::optional<nanoseconds> time) noexcept {
  nanoseconds start = clock_.now();  // the show's time 0: when its first frame is seen
  nanoseconds next = start;          // when the coming frame is to be seen
  bool shown = false;
  for (;;) {
    if (interrupted()) return LoopEnd::kInterrupted;
    if (time && next - start + period_ / 4 >= *time) return LoopEnd::kTimeUp;
    const FrameMaker::Change change = show_.advance(next - start, next);
    if (change == FrameMaker::Change::kOver) return LoopEnd::kOver;
    note_trouble(change == FrameMaker::Change::kFailed);
    Presented presented;
    if (change == FrameMaker::Change::kNew || !shown) {
      const DisplayBuffer buffer = display_.back_buffer();
      if (!buffer.data) return LoopEnd::kLost;
      const nanoseconds begun = clock_.now();
      const WarpWork work = show_.warp(image_of(buffer), buffer.age);
      counts_.tiles_warped += work.pieces;
      counts_.tiles_skipped += work.skipped;
      warp_times_[warps_++ % warp_times_.size()] = clock_.now() - begun;
      presented = display_.present(next);
    } else {
      presented = display_.repeat(next);
      if (presented.result == Present::kShown) ++counts_.frames_unchanged;
    }
    if (presented.result == Present::kClosed) return LoopEnd::kClosed;
    if (presented.result == Present::kLost) return LoopEnd::kLost;
    note_absence(presented.result == Present::kAway);
    if (!shown) start = next = presented.flipped_at;
    shown = true;
    if (!away_) show_.shown(presented.flipped_at);
    ++(away_ ? counts_.frames_unshown : counts_.frames_presented);
    const nanoseconds behind = presented.flipped_at - next;
    if (!away_ && behind > period_ / 2) ++counts_.frames_late;
    if (display_.period() > nanoseconds(0)) {
      period_ = display_.period();
      // The flips set the pace: whole periods behind are flips that showed the frame before once more.
      counts_.frames_dropped += (behind + period_ / 2) / period_;
      next = presented.flipped_at + period_;
    } else {
      const std::int64_t missed = std::max<std::int64_t>(0, behind / period_);
      counts_.frames_dropped += missed;
      next += (missed + 1) * period_;
    }
  }
}

void FrameLoop::note_trouble(bool failed) noexcept {
  if (failed) ++counts_.frames_failed;
  if (failed == failing_) return;
  failing_ = failed;
  if (failed) {
    std::fprintf(stderr, "cupola: %s\n", show_.trouble().c_str());
  } else {
    std::fputs("cupola: the faces are back\n", stderr);
  }
}

void FrameLoop::note_absence(bool away) noexcept {
  if (away == away_) return;
  away_ = away;
  if (away) {
    ++counts_.display_losses;
    std::fprintf(stderr, "cupola: the display is away: %s\n", display_.trouble());
  } else {
    std::fputs("cupola: the display is back\n", stderr);
  }
}

std::vector<double> FrameLoop::warp_ms() const {
  std::vector<double> times;
  for (std::size_t i = warps_ - std::min(warps_, warp_times_.size()); i < warps_; ++i) {
    times.push_back(1e-6 * static_cast<double>(warp_times_[i % warp_times_.size()].count()));
  }
  return times;
}

}  // namespace cupola
