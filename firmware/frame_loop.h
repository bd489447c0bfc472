// The frame loop: faces, warp, display, one flip after the other, and what was counted meanwhile.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "firmware/control_link.h"
#include "firmware/control_panel.h"
#include "firmware/frame_maker.h"
#include "firmware/frame_mix.h"
#include "firmware/loop_counts.h"
#include "firmware/operator_wishes.h"
#include "firmware/time_ring.h"
#include "hal/display/display.h"
#include "hal/time/clock.h"
#include "pipeline/parallel/worker_pool.h"

namespace cupola {

enum class LoopEnd : std::uint8_t { kOver, kTimeUp, kClosed, kLost, kInterrupted };

class FrameLoop {
 public:
  // All are borrowed for the loop's life. `pool` is the one that `show` uses; there may be no `panel` and
  // nobody at the other end of `link`.
  FrameLoop(FrameMaker& show, Display& display, Clock& clock, WorkerPool& pool, ControlPanel* panel = nullptr,
            ControlLink* link = nullptr);

  // Plays until the show is over, or for `time`, pauses included. Allocates nothing but to say, once a
  // change, what went wrong.
  LoopEnd run(std::optional<std::chrono::nanoseconds> time) noexcept;

  const LoopCounts& counts() const { return counts_; }
  // Of the last frames, in the order they were made; milliseconds of the given clock.
  std::vector<double> warp_ms() const { return warp_times_.milliseconds(); }

 private:
  LoopEnd play(std::optional<std::chrono::nanoseconds> time) noexcept;
  void dim_into(const MutableImage& buffer, bool changed) noexcept;
  FrameMaker::Change advance(const FrameMaker::Due& due) noexcept;
  Presented show_black(std::chrono::nanoseconds when) noexcept;
  void trace(std::chrono::nanoseconds faces_begun, std::chrono::nanoseconds warp_begun) noexcept;
  Presented show_pattern(const ImageBuffer& pattern, std::chrono::nanoseconds when) noexcept;
  void give_screenshot(std::int32_t light) noexcept;
  void count_dropped(std::int64_t frames, std::chrono::nanoseconds due) noexcept;
  std::chrono::nanoseconds paced(std::chrono::nanoseconds passed) const noexcept;
  void publish(PlayerState state) noexcept;
  void note_trouble(bool failed) noexcept;
  void note_absence(bool away) noexcept;

  FrameMaker* show_;
  Display& display_;
  Clock& clock_;
  WorkerPool* pool_;
  ControlPanel* panel_;
  std::unique_ptr<ControlLink> own_link_;  // where none was given
  ControlLink& link_;
  OperatorWishes wishes_;
  std::chrono::nanoseconds period_;
  LoopCounts counts_;
  PlayerStatus status_;
  std::size_t noted_cue_ = 0;
  std::chrono::nanoseconds faces_done_{0};  // of the last frame: when each stage had ended
  std::chrono::nanoseconds warp_done_{0};
  std::int64_t made_ = 0;              // frames, for the trace
  ImageBuffer undimmed_;               // the frame before it is dimmed; displays' memory may be slow to read
  bool undimmed_holds_ = false;        // it holds the frame warped last
  std::int32_t light_ = kWholeWeight;  // of what was presented last
  bool failing_ = false;
  bool away_ = false;
  std::chrono::nanoseconds advanced_{0};                          // the show's time of the last advance()
  std::array<PlayerCommand, CommandQueue::kSlots + 2> commands_;  // of a show that was read again
  bool replaced_ = false;                 // by such a one, which was not presented yet
  bool black_ = false;                    // what was presented last: ...
  const ImageBuffer* pattern_ = nullptr;  // ... or this; null: a frame of the show
  std::size_t pattern_laid_ = 0;          // which it is
  Screenshot* screenshot_ = nullptr;      // to be filled with the coming frame
  int since_black_ =
      0;  // presents since then, or since another show: older buffers hold no frame of this one
  TimeRing warp_times_;
};

}  // namespace cupola
