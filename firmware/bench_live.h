// What a live show takes, measured in real time: cameras that are memory, the shipped frame loop, a display
// that is memory.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "firmware/frame_loop.h"
#include "firmware/paced_camera.h"
#include "firmware/percentile.h"
#include "pipeline/optics/rig.h"
#include "pipeline/warp/cpu.h"

namespace cupola {

struct LiveBench {
  LoopCounts counts;
  Percentiles latency_ms{{}};  // from the timestamp of a set's first frame to the flip that showed the set
  Percentiles warp_ms{{}};     // of a frame
  double period_ms = 0.0;      // of the display, 60 Hz
  std::int64_t sets = 0;
  std::int64_t whole_sets = 0;
  std::int64_t bytes_copied = 0;
  std::int64_t frames_dropped = 0;  // by the cameras, all of them
};

// Plays for `time`, a camera a view, all as `camera` but for their numbers.
LiveBench measure_live(const Rig& rig, PacedCameraDevice camera, std::chrono::nanoseconds time, Cpu cpu,
                       WorkerPool& pool);

}  // namespace cupola
