// What the frame loop counts, from its first frame on.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "pipeline/warp/frame_warp.h"

namespace cupola {

// How long something took, as Prometheus has it: how often at most each of the bounds, and the sum.
struct StageTimes {
  static constexpr std::array<std::chrono::microseconds, 12> kUpTo = {
      std::chrono::microseconds(500),    std::chrono::microseconds(1'000),
      std::chrono::microseconds(2'000),  std::chrono::microseconds(4'000),
      std::chrono::microseconds(6'000),  std::chrono::microseconds(8'000),
      std::chrono::microseconds(10'000), std::chrono::microseconds(13'000),
      std::chrono::microseconds(17'000), std::chrono::microseconds(25'000),
      std::chrono::microseconds(50'000), std::chrono::microseconds(100'000)};
  std::array<std::int64_t, kUpTo.size()> within{};  // each beyond the bound before
  std::int64_t beyond = 0;                          // the last bound
  std::chrono::nanoseconds sum{0};
  std::chrono::nanoseconds last{0};

  void note(std::chrono::nanoseconds took) noexcept {
    std::size_t i = 0;
    while (i < kUpTo.size() && took > kUpTo[i]) ++i;
    ++(i < kUpTo.size() ? within[i] : beyond);
    sum += took;
    last = took;
  }
};

struct LoopCounts {
  std::int64_t frames_presented = 0;    // shown, unchanged ones included
  std::int64_t frames_unshown = 0;      // presented to a display that was away
  std::int64_t display_losses = 0;      // times it went away
  std::int64_t frames_unchanged = 0;    // of the shown: not warped, since nothing had changed
  std::int64_t blackout_frames = 0;     // of the shown: black by the operator's wish
  std::int64_t frames_nv12 = 0;         // warped from NV12 or other YUV into NV12, and presented
  WarpWork tiles;                       // of the frames that were not unchanged
  std::int64_t frames_late = 0;         // shown more than half a period after their time
  std::int64_t frames_dropped = 0;      // times of the show that passed without a frame of their own,
  std::int64_t dropped_by_faces = 0;    // of these: the faces came after the flip's time,
  std::int64_t dropped_by_warp = 0;     // or they came in time, and the warp was done after it,
  std::int64_t dropped_by_display = 0;  // or that was in time too, and the flip was late
  std::int64_t frames_failed = 0;       // times at which the faces could not be had
  std::int64_t heap_allocations =
      0;  // operator new, by the loop's thread and the pool's, from first frame to last
  std::int64_t heap_allocations_elsewhere = 0;  // operator new, by all other threads meanwhile
  std::int64_t pixel_bytes_copied =
      0;  // by the loop outside the warp: it warps into the display's own buffer
  std::int64_t preview_bytes_copied = 0;  // for the control page, while somebody looks at it
  std::int64_t screenshots = 0;           // frames made in memory first, and copied to the display
  StageTimes faces;                       // of every frame; live ones wait for the flip's sake
  StageTimes warp;                        // of the frames that were warped
};

}  // namespace cupola
