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
#include "firmware/frame_presenter.h"
#include "firmware/loop_counts.h"
#include "firmware/operator_wishes.h"
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
  std::vector<double> warp_ms() const { return presenter_.warp_times().milliseconds(); }

 private:
  LoopEnd play(std::optional<std::chrono::nanoseconds> time) noexcept;
  FrameMaker::Change advance() noexcept;
  FrameMaker::Change advance(const FrameMaker::Due& due) noexcept;
  Presented present(FrameMaker::Change change, bool dark) noexcept;
  void follow(const Presented& presented) noexcept;
  void trace() noexcept;
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
  LoopCounts counts_;
  FramePresenter presenter_;
  std::chrono::nanoseconds period_;
  // When the coming frame is to be seen, and when the one before was to be.
  std::chrono::nanoseconds next_{0};
  std::chrono::nanoseconds previous_{0};
  std::chrono::nanoseconds start_{0};  // the show's time 0: when its first frame is seen
  std::chrono::nanoseconds begun_{0};  // the same, but not moved by pauses
  bool shown_ = false;                 // that first frame
  PlayerStatus status_;
  std::size_t noted_cue_ = 0;
  std::chrono::nanoseconds faces_begun_{0};  // of the last frame
  std::chrono::nanoseconds faces_done_{0};
  std::int64_t made_ = 0;   // frames, for the trace
  std::int64_t ahead_ = 0;  // of them decoded, as the trace has it
  bool failing_ = false;
  bool away_ = false;
  std::chrono::nanoseconds advanced_{0};                          // the show's time of the last advance()
  std::array<PlayerCommand, CommandQueue::kSlots + 2> commands_;  // of a show that was read again
};

}  // namespace cupola
