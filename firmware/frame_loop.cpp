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

namespace {

constexpr int kOldest = 64;  // presents; no display has so many buffers

MutableImage image_of(const DisplayBuffer& buffer) {
  return {PixelFormat::kXrgb8888, {buffer.width, buffer.height}, {{{buffer.data, buffer.stride}, {}, {}}}};
}

}  // namespace

FrameLoop::FrameLoop(FrameMaker& show, Display& display, Clock& clock, WorkerPool& pool, ControlPanel* panel,
                     ControlLink* link)
    : show_(&show),
      display_(display),
      clock_(clock),
      pool_(&pool),
      panel_(panel),
      own_link_(link ? nullptr : std::make_unique<ControlLink>()),
      link_(link ? *link : *own_link_),
      period_(display.period()),
      warp_times_(65536) {
  if (period_ <= nanoseconds(0)) period_ = nanoseconds(std::llround(1e9 / show.rate()));
}

LoopEnd FrameLoop::run(std::optional<nanoseconds> time) noexcept {
  const DisplayBuffer buffer = display_.back_buffer();
  if (buffer.data) undimmed_ = ImageBuffer(PixelFormat::kXrgb8888, {buffer.width, buffer.height});
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
  nanoseconds start = clock_.now();  // the show's time 0: when its first frame is seen
  nanoseconds next = start;          // when the coming frame is to be seen
  nanoseconds previous = start;
  nanoseconds begun = start;  // unlike `start`, not moved by pauses
  bool shown = false;
  for (;;) {
    if (interrupted()) return LoopEnd::kInterrupted;
    if (time && next - begun + period_ / 4 >= *time) return LoopEnd::kTimeUp;
    const bool dark = panel_ && panel_->poll(link_.commands);
    wishes_.obey(link_.commands, next);
    if (wishes_.held()) {
      start += next - previous;
    } else {
      start -= paced(next - previous);
    }
    previous = next;
    status_.due = next;
    const nanoseconds faces_begun = clock_.now();
    const FrameMaker::Change change = advance({next - start, next, wishes_.for_show()});
    if (change == FrameMaker::Change::kOver) return LoopEnd::kOver;
    faces_done_ = warp_done_ = clock_.now();
    nanoseconds warp_begun = faces_done_;
    counts_.faces.note(faces_done_ - faces_begun);
    show_->report(status_.show);
    note_trouble(change == FrameMaker::Change::kFailed);
    Presented presented;
    if (link_.reload && wishes_.reload()) link_.reload->ask();
    const bool uncover = (black_ || pattern_ || replaced_) && change != FrameMaker::Change::kFailed;
    const bool looked_at =
        link_.preview && link_.preview->wants(next) && change == FrameMaker::Change::kUnchanged;
    const bool relit = wishes_.light() != light_ || wishes_.light() != kWholeWeight;
    const ImageBuffer* pattern = link_.patterns ? link_.patterns->picture(wishes_.pattern()) : nullptr;
    if (link_.screenshots && wishes_.screenshot()) link_.screenshots->ask();
    if (link_.screenshots && !screenshot_) screenshot_ = link_.screenshots->due();
    const bool covered = dark || wishes_.black() || pattern;
    if (covered && change == FrameMaker::Change::kNew) undimmed_holds_ = false;  // of what is not seen
    if (dark || wishes_.black()) {
      presented = show_black(next);
      if (link_.preview) counts_.preview_bytes_copied += link_.preview->copy_black(next);
      if (screenshot_) give_screenshot(0);
    } else if (pattern) {
      presented = show_pattern(*pattern, next);
      if (link_.preview) {
        counts_.preview_bytes_copied += link_.preview->copy(pattern->pixels(), next);
      }
    } else if (change == FrameMaker::Change::kNew || uncover || looked_at || relit || !shown || screenshot_) {
      const DisplayBuffer buffer = display_.back_buffer();
      if (!buffer.data) return LoopEnd::kLost;
      warp_begun = clock_.now();
      light_ = wishes_.light();
      if (light_ < kWholeWeight || screenshot_) {
        dim_into(image_of(buffer),
                 change != FrameMaker::Change::kUnchanged && change != FrameMaker::Change::kFailed);
      } else {
        counts_.tiles += show_->warp(image_of(buffer), buffer.age <= since_black_ ? buffer.age : 0);
        undimmed_holds_ = false;
      }
      warp_done_ = clock_.now();
      warp_times_.add(warp_done_ - warp_begun);
      counts_.warp.note(warp_done_ - warp_begun);
      if (link_.preview) counts_.preview_bytes_copied += link_.preview->copy(image_of(buffer), next);
      presented = display_.present(next);
      if (screenshot_) {
        std::swap(screenshot_->frame, undimmed_);
        undimmed_holds_ = false;
        give_screenshot(light_);
      }
      black_ = replaced_ = false;
      pattern_ = nullptr;
      since_black_ = light_ < kWholeWeight ? 0 : std::min(since_black_ + 1, kOldest);
    } else {
      presented = display_.repeat(next);
      if (presented.result == Present::kShown) ++counts_.frames_unchanged;
    }
    trace(faces_begun, warp_begun);
    if (presented.result == Present::kClosed) return LoopEnd::kClosed;
    if (presented.result == Present::kLost) return LoopEnd::kLost;
    note_absence(presented.result == Present::kAway);
    if (panel_) panel_->flipped(black_, wishes_.held());
    if (!shown) begun = start = previous = next = status_.due = presented.flipped_at;
    shown = true;
    if (!away_ && !black_) show_->shown(presented.flipped_at);
    if (link_.faces) counts_.preview_bytes_copied += link_.faces->copy(*show_, next);
    ++(away_ ? counts_.frames_unshown : counts_.frames_presented);
    counts_.blackout_frames += black_ ? 1 : 0;
    const nanoseconds behind = presented.flipped_at - next;
    if (!away_ && behind > period_ / 2) {
      ++counts_.frames_late;
      link_.trace.add(TraceWhat::kLate, presented.flipped_at, presented.flipped_at, 1);
    }
    if (display_.period() > nanoseconds(0)) {
      period_ = display_.period();
      // The flips set the pace: whole periods behind are flips that showed the frame before once more.
      count_dropped((behind + period_ / 2) / period_, next);
      next = presented.flipped_at + period_;
    } else {
      const std::int64_t missed = std::max<std::int64_t>(0, behind / period_);
      count_dropped(missed, next);
      next += (missed + 1) * period_;
    }
    status_.running = presented.flipped_at - begun;
    status_.shown_at = presented.flipped_at;
    publish(wishes_.held()         ? PlayerState::kPaused
            : status_.show.waiting ? PlayerState::kWaiting
                                   : PlayerState::kPlaying);
  }
}

// By how much more than the clock's the show's time moves on while `passed` passes there.
nanoseconds FrameLoop::paced(nanoseconds passed) const noexcept {
  const std::int64_t most = 5'000'000;
  const std::int64_t pace = std::clamp(link_.pace_ppb.load(std::memory_order_relaxed), -most, most);
  return nanoseconds(std::llround(1e-9 * static_cast<double>(passed.count()) * static_cast<double>(pace)));
}

// The stages lie within the frame, one after the other.
void FrameLoop::trace(nanoseconds faces_begun, nanoseconds warp_begun) noexcept {
  const nanoseconds done = clock_.now();
  ++made_;
  link_.trace.add(TraceWhat::kFrame, faces_begun, done, made_);
  link_.trace.add(TraceWhat::kFaces, faces_begun, faces_done_, made_);
  if (warp_done_ > warp_begun) link_.trace.add(TraceWhat::kWarp, warp_begun, warp_done_, made_);
  link_.trace.add(TraceWhat::kPresent, warp_done_, done, made_);
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
  replaced_ = true;
  since_black_ = 0;
  undimmed_holds_ = false;
  noted_cue_ = place.value_or(0);
  link_.reload->taken(ready);
  return show_->advance({due.time, due.flip, {commands_.data(), count}});
}

void FrameLoop::count_dropped(std::int64_t frames, nanoseconds due) noexcept {
  if (frames > 0) link_.trace.add(TraceWhat::kDropped, due, due, frames);
  counts_.frames_dropped += frames;
  (faces_done_ > due  ? counts_.dropped_by_faces
   : warp_done_ > due ? counts_.dropped_by_warp
                      : counts_.dropped_by_display) += frames;
}

// Also into the log, what has changed.
void FrameLoop::publish(PlayerState state) noexcept {
  if (status_.show.cue != noted_cue_) {
    std::array<char, 32> words{};
    std::snprintf(words.data(), words.size(), "cue %zu", status_.show.cue + 1);
    link_.log.info(Topic::kShow, words.data());
    noted_cue_ = status_.show.cue;
  }
  if (status_.state != state) link_.log.info(Topic::kShow, name_of(state));
  if (status_.black != black_) link_.log.info(Topic::kControl, black_ ? "dark" : "no longer dark");
  status_.state = state;
  const std::size_t pattern = pattern_ ? pattern_laid_ : 0;
  if (status_.pattern != pattern)
    link_.log.info(Topic::kControl, pattern ? "a test pattern is laid" : "no test pattern");
  status_.pattern = pattern;
  status_.black = black_;
  status_.volume = wishes_.volume();
  status_.light = static_cast<double>(wishes_.light()) / kWholeWeight;
  status_.display_away = away_;
  status_.failing = failing_;
  status_.counts = counts_;
  status_.period = period_;
  link_.status.publish(status_);
}

void FrameLoop::dim_into(const MutableImage& buffer, bool changed) noexcept {
  if (changed || !undimmed_holds_) {
    counts_.tiles += show_->warp(undimmed_.pixels(), undimmed_holds_ ? 1 : 0);
    undimmed_holds_ = true;
  }
  dim(as_const(undimmed_.pixels()), light_, buffer, *pool_);
}

// Once; then it stands.
Presented FrameLoop::show_black(nanoseconds when) noexcept {
  if (black_) return display_.repeat(when);
  const DisplayBuffer buffer = display_.back_buffer();
  if (!buffer.data) return {Present::kLost, clock_.now()};
  for (int y = 0; y < buffer.height; ++y) {
    auto* row = reinterpret_cast<std::uint32_t*>(buffer.data + y * buffer.stride);
    std::fill_n(row, buffer.width, 0xff000000U);
  }
  black_ = true;
  pattern_ = nullptr;
  since_black_ = 0;
  return display_.present(when);
}

// Once, and again when it or the light changes; then it stands.
Presented FrameLoop::show_pattern(const ImageBuffer& pattern, nanoseconds when) noexcept {
  if (screenshot_) {
    dim(pattern.pixels(), wishes_.light(), screenshot_->frame.pixels(), *pool_);
    give_screenshot(kWholeWeight);
  }
  const std::size_t laid = link_.patterns->laid();
  if (pattern_ == &pattern && pattern_laid_ == laid && light_ == wishes_.light()) {
    return display_.repeat(when);
  }
  const DisplayBuffer buffer = display_.back_buffer();
  if (!buffer.data) return {Present::kLost, clock_.now()};
  light_ = wishes_.light();
  dim(pattern.pixels(), light_, image_of(buffer), *pool_);
  pattern_ = &pattern;
  pattern_laid_ = laid;
  black_ = false;
  since_black_ = 0;
  return display_.present(when);
}

void FrameLoop::give_screenshot(std::int32_t light) noexcept {
  screenshot_->light = light;
  screenshot_->cue = status_.show.cue;
  screenshot_->position = status_.show.position;
  link_.screenshots->give_back(screenshot_);
  screenshot_ = nullptr;
  ++counts_.screenshots;
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
