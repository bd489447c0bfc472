// What is seen of a frame: black, a test pattern, the show's picture by the operator's light, or what stands.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/control_link.h"
#include "firmware/frame_maker.h"
#include "firmware/loop_counts.h"
#include "firmware/operator_wishes.h"
#include "firmware/time_ring.h"
#include "hal/display/display.h"
#include "hal/time/clock.h"
#include "pipeline/parallel/worker_pool.h"

namespace cupola {

class FramePresenter {
 public:
  // All are borrowed for the presenter's life.
  FramePresenter(Display& display, Clock& clock, ControlLink& link, LoopCounts& counts);

  // Takes the memory that light and screenshots need, and agrees with the display on NV12 if `show` has it.
  void prepare(const FrameMaker& show);

  struct Frame {
    FrameMaker& show;  // advanced
    WorkerPool& pool;  // the show's
    FrameMaker::Change change;
    const OperatorWishes& wishes;
    bool dark;  // by a line
    const ShowReport& report;
    std::chrono::nanoseconds flip;  // at which it is to be seen
  };
  // Waits for the flip, as the display does. Does not allocate.
  Presented present(const Frame& frame) noexcept;
  // The next frame is another show's than the ones before.
  void begin_show() noexcept;

  bool black() const noexcept { return black_; }
  // The test pattern that was presented last, from 1; 0: none.
  std::size_t pattern() const noexcept { return pattern_ ? pattern_laid_ : 0; }
  // Of the last frame; the same where nothing was warped.
  std::chrono::nanoseconds warp_begun() const noexcept { return warp_begun_; }
  std::chrono::nanoseconds warp_done() const noexcept { return warp_done_; }
  // Of the last 65,536 frames warped.
  const TimeRing& warp_times() const noexcept { return warp_times_; }

 private:
  Presented present_black(const Frame& frame) noexcept;
  Presented present_pattern(const Frame& frame, const ImageBuffer& pattern) noexcept;
  Presented present_picture(const Frame& frame) noexcept;
  Presented present_nv12(const Frame& frame) noexcept;
  void note_picture() noexcept;
  void warp_into(const MutableImage& buffer, int age, const Frame& frame) noexcept;
  void note_warp() noexcept;
  void dim_into(const MutableImage& buffer, const Frame& frame) noexcept;
  void give_screenshot(const Frame& frame, std::int32_t light) noexcept;

  Display& display_;
  Clock& clock_;
  ControlLink& link_;
  LoopCounts& counts_;
  ImageBuffer undimmed_;               // the frame before it is dimmed; displays' memory may be slow to read
  bool undimmed_holds_ = false;        // it holds the frame warped last
  bool stands_ = false;                // something was presented: what is unchanged need not be again
  std::int32_t light_ = kWholeWeight;  // of what was presented last
  bool black_ = false;                 // what was presented last: ...
  const ImageBuffer* pattern_ = nullptr;  // ... or this; null: a frame of the show
  std::size_t pattern_laid_ = 0;          // which it is
  bool another_show_ = false;             // has begun, and was not presented yet
  std::optional<YuvColour> nv12_;         // the display takes it
  bool was_nv12_ = false;                 // what was presented last
  // Presents since another picture, format or show: older buffers hold no frame of this one.
  int since_other_ = 0;
  Screenshot* screenshot_ = nullptr;  // to be filled with the coming frame
  std::chrono::nanoseconds warp_begun_{0};
  std::chrono::nanoseconds warp_done_{0};
  TimeRing warp_times_;
};

}  // namespace cupola
