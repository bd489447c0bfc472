// The frame loop: faces, warp, display, one flip after the other, and what was counted meanwhile.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware/frame_maker.h"
#include "hal/display/display.h"
#include "hal/time/clock.h"
#include "pipeline/parallel/worker_pool.h"

namespace cupola {

struct LoopCounts {
  std::int64_t frames_presented = 0;  // shown, unchanged ones included
  std::int64_t frames_unshown = 0;    // presented to a display that was away
  std::int64_t display_losses = 0;    // times it went away
  std::int64_t frames_unchanged = 0;  // of the shown: not warped, since nothing had changed
  std::int64_t tiles_warped = 0;      // parts of the warped frames that were made,
  std::int64_t tiles_skipped = 0;     // and that were left as they were, since nothing in them had changed
  std::int64_t frames_late = 0;       // shown more than half a period after their time
  std::int64_t frames_dropped = 0;    // times of the show that passed without a frame of their own
  std::int64_t frames_failed = 0;     // times at which the faces could not be had
  std::int64_t heap_allocations =
      0;  // operator new, by the loop's thread and the pool's, from first frame to last
  std::int64_t heap_allocations_elsewhere = 0;  // operator new, by all other threads meanwhile
  std::int64_t pixel_bytes_copied =
      0;  // by the loop outside the warp: it warps into the display's own buffer
};

enum class LoopEnd : std::uint8_t { kOver, kTimeUp, kClosed, kLost, kInterrupted };

class FrameLoop {
 public:
  // All are borrowed for the loop's life. `pool` is the one that `show` uses.
  FrameLoop(FrameMaker& show, Display& display, Clock& clock, WorkerPool& pool);

  // Plays until the show is over, or for `time` of it. Allocates nothing but to say, once a change, what
  // went wrong.
  LoopEnd run(std::optional<std::chrono::nanoseconds> time) noexcept;

  const LoopCounts& counts() const { return counts_; }
  // Of the last frames, in the order they were made; milliseconds of the given clock.
  std::vector<double> warp_ms() const;

 private:
  LoopEnd play(std::optional<std::chrono::nanoseconds> time) noexcept;
  void note_trouble(bool failed) noexcept;
  void note_absence(bool away) noexcept;

  FrameMaker& show_;
  Display& display_;
  Clock& clock_;
  WorkerPool& pool_;
  std::chrono::nanoseconds period_;
  LoopCounts counts_;
  bool failing_ = false;
  bool away_ = false;
  std::vector<std::chrono::nanoseconds> warp_times_;  // a ring
  std::size_t warps_ = 0;
};

}  // namespace cupola
