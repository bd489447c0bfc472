// Pacing: each frame is made for the flip it will be seen at.
// SPDX-License-Identifier: MIT
#include "firmware/frame_loop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "firmware/heap_count.h"
#include "firmware/interrupt.h"

namespace cupola {

using std::chrono::nanoseconds;

FrameLoop::FrameLoop(FrameMaker& show, Display& display, Clock& clock, WorkerPool& pool, ControlPanel* panel,
                     ControlLink* link)
    : show_(&show),
      display_(display),
      clock_(clock),
      pool_(&pool),
      panel_(panel),
      own_link_(link ? nullptr : std::make_unique<ControlLink>()),
      link_(link ? *link : *own_link_),
      presenter_(display, clock, link_, counts_),
      period_(display.period()) {
  if (period_ <= nanoseconds(0)) period_ = nanoseconds(std::llround(1e9 / show.rate()));
}

LoopEnd FrameLoop::run(std::optional<nanoseconds> time) noexcept {
  presenter_.prepare(*show_);
  join_frame_loop(*pool_);
  const HeapAllocations before = heap_allocations();
  const LoopEnd end = play(time);
  const HeapAllocations after = heap_allocations();
  leave_frame_loop();
  publish(PlayerState::kOver);
  if (panel_) panel_->rest();
  counts_.heap_allocations = after.frame_loop - before.frame_loop;
  counts_.heap_allocations_elsewhere = after.elsewhere - before.elsewhere;
  return end;
}

LoopEnd FrameLoop::play(std::optional<nanoseconds> time) noexcept {
  start_ = next_ = previous_ = begun_ = clock_.now();
  for (;;) {
    if (interrupted()) return LoopEnd::kInterrupted;
    if (time && next_ - begun_ + period_ / 4 >= *time) return LoopEnd::kTimeUp;
    const bool dark = panel_ && panel_->poll(link_.commands);
    wishes_.obey(link_.commands, next_);
    if (link_.reload && wishes_.reload()) link_.reload->ask();
    const FrameMaker::Change change = advance();
    if (change == FrameMaker::Change::kOver) return LoopEnd::kOver;
    const Presented presented = present(change, dark);
    if (presented.result == Present::kClosed) return LoopEnd::kClosed;
    if (presented.result == Present::kLost) return LoopEnd::kLost;
    follow(presented);
    publish(wishes_.held()         ? PlayerState::kPaused
            : status_.show.waiting ? PlayerState::kWaiting
                                   : PlayerState::kPlaying);
  }
}

// To the time at which the coming frame will be seen.
FrameMaker::Change FrameLoop::advance() noexcept {
  const nanoseconds passed = next_ - previous_;
  start_ += wishes_.held() ? passed : -paced(passed);
  previous_ = next_;
  status_.due = next_;
  faces_begun_ = clock_.now();
  const FrameMaker::Change change = advance({next_ - start_, next_, wishes_.for_show()});
  if (change == FrameMaker::Change::kOver) return change;
  faces_done_ = clock_.now();
  counts_.faces.note(faces_done_ - faces_begun_);
  show_->report(status_.show);
  note_trouble(change == FrameMaker::Change::kFailed);
  return change;
}

Presented FrameLoop::present(FrameMaker::Change change, bool dark) noexcept {
  const Presented presented =
      presenter_.present({*show_, *pool_, change, wishes_, dark, status_.show, next_});
  trace();
  if (presented.result == Present::kClosed || presented.result == Present::kLost) return presented;
  note_absence(presented.result == Present::kAway);
  if (panel_) panel_->flipped(presenter_.black(), wishes_.held());
  if (!away_ && !presenter_.black()) show_->shown(presented.flipped_at);
  if (link_.faces) counts_.preview_bytes_copied += link_.faces->copy(*show_, next_);
  ++(away_ ? counts_.frames_unshown : counts_.frames_presented);
  counts_.blackout_frames += presenter_.black() ? 1 : 0;
  return presented;
}

// Finds when the next frame is to be seen, and what was missed.
void FrameLoop::follow(const Presented& presented) noexcept {
  if (!shown_) begun_ = start_ = previous_ = next_ = status_.due = presented.flipped_at;
  shown_ = true;
  const nanoseconds behind = presented.flipped_at - next_;
  if (!away_ && behind > period_ / 2) {
    ++counts_.frames_late;
    link_.trace.add(TraceWhat::kLate, presented.flipped_at, presented.flipped_at, 1);
  }
  if (display_.period() > nanoseconds(0)) {
    period_ = display_.period();
    // The flips set the pace: whole periods behind are flips that showed the frame before once more.
    count_dropped((behind + period_ / 2) / period_, next_);
    next_ = presented.flipped_at + period_;
  } else {
    const std::int64_t missed = std::max<std::int64_t>(0, behind / period_);
    count_dropped(missed, next_);
    next_ += (missed + 1) * period_;
  }
  status_.running = presented.flipped_at - begun_;
  status_.shown_at = presented.flipped_at;
}

// By how much more than the clock's the show's time moves on while `passed` passes there.
nanoseconds FrameLoop::paced(nanoseconds passed) const noexcept {
  const std::int64_t most = 5'000'000;
  const std::int64_t pace = std::clamp(link_.pace_ppb.load(std::memory_order_relaxed), -most, most);
  return nanoseconds(std::llround(1e-9 * static_cast<double>(passed.count()) * static_cast<double>(pace)));
}

// The stages lie within the frame, one after the other.
void FrameLoop::trace() noexcept {
  const nanoseconds done = clock_.now();
  const nanoseconds warp_begun = presenter_.warp_begun();
  const nanoseconds warp_done = presenter_.warp_done();
  ++made_;
  link_.trace.add(TraceWhat::kFrame, faces_begun_, done, made_);
  link_.trace.add(TraceWhat::kFaces, faces_begun_, faces_done_, made_);
  if (warp_done > warp_begun) link_.trace.add(TraceWhat::kWarp, warp_begun, warp_done, made_);
  link_.trace.add(TraceWhat::kPresent, warp_done, done, made_);
  const auto ahead = static_cast<std::int64_t>(status_.show.queue.frames);
  if (ahead == std::exchange(ahead_, ahead)) return;
  link_.trace.add(TraceWhat::kAhead, faces_done_, faces_done_, ahead);
}

// By the show that was read again, as soon as there is one: at the place that the one before would have come
// to. The cues that the operator named are that one's.
FrameMaker::Change FrameLoop::advance(const FrameMaker::Due& due) noexcept {
  const nanoseconds passed = due.time - std::exchange(advanced_, due.time);
  ReadyShow* ready = link_.reload ? link_.reload->take() : nullptr;
  if (!ready) return show_->advance(due);
  const auto place_of = [&](std::size_t cue) {
    return cue < ready->places.size() ? ready->places[cue] : std::nullopt;
  };
  const std::optional<std::size_t> place = place_of(status_.show.cue);
  std::size_t count = 0;
  commands_[count++] = {PlayerAction::kCue, nanoseconds(0), place.value_or(0)};
  if (place) commands_[count++] = {PlayerAction::kSeek, status_.show.position + passed};
  for (PlayerCommand command : due.commands) {
    if (command.action == PlayerAction::kCue) {
      const std::optional<std::size_t> named = place_of(command.cue);
      if (!named) continue;
      command.cue = *named;
    }
    commands_[count++] = command;
  }
  show_ = ready->maker.get();
  status_.show_number = ready->number;
  pool_ = &*ready->pool;
  presenter_.begin_show();
  noted_cue_ = place.value_or(0);
  link_.reload->taken(ready);
  return show_->advance({due.time, due.flip, {commands_.data(), count}});
}

void FrameLoop::count_dropped(std::int64_t frames, nanoseconds due) noexcept {
  if (frames > 0) link_.trace.add(TraceWhat::kDropped, due, due, frames);
  counts_.frames_dropped += frames;
  (faces_done_ > due              ? counts_.dropped_by_faces
   : presenter_.warp_done() > due ? counts_.dropped_by_warp
                                  : counts_.dropped_by_display) += frames;
}

// Also into the log, what has changed.
void FrameLoop::publish(PlayerState state) noexcept {
  if (status_.show.cue != noted_cue_) {
    std::array<char, 32> words{};
    std::snprintf(words.data(), words.size(), "cue %zu", status_.show.cue + 1);
    link_.log.info(Topic::kShow, words.data());
    link_.trace.add(TraceWhat::kCue, faces_done_, faces_done_,
                    static_cast<std::int64_t>(status_.show.cue + 1));
    noted_cue_ = status_.show.cue;
  }
  if (status_.state != state) link_.log.info(Topic::kShow, name_of(state));
  const bool black = presenter_.black();
  if (status_.black != black) link_.log.info(Topic::kControl, black ? "dark" : "no longer dark");
  status_.state = state;
  const std::size_t pattern = presenter_.pattern();
  if (status_.pattern != pattern)
    link_.log.info(Topic::kControl, pattern ? "a test pattern is laid" : "no test pattern");
  status_.pattern = pattern;
  status_.black = black;
  status_.volume = wishes_.volume();
  status_.light = static_cast<double>(wishes_.light()) / kWholeWeight;
  status_.display_away = away_;
  status_.failing = failing_;
  status_.counts = counts_;
  status_.period = period_;
  link_.status.publish(status_);
}

void FrameLoop::note_trouble(bool failed) noexcept {
  if (failed) ++counts_.frames_failed;
  if (failed == failing_) return;
  failing_ = failed;
  if (failed) {
    link_.log.warn(Topic::kShow, status_.show.trouble.data());
  } else {
    link_.log.notice(Topic::kShow, "the faces are back");
  }
}

void FrameLoop::note_absence(bool away) noexcept {
  if (away == away_) return;
  away_ = away;
  if (away) {
    ++counts_.display_losses;
    std::array<char, EventLog::kLongest> words{};
    std::snprintf(words.data(), words.size(), "the display is away: %s", display_.trouble());
    link_.log.warn(Topic::kDisplay, words.data());
  } else {
    link_.log.notice(Topic::kDisplay, "the display is back");
  }
}

}  // namespace cupola
