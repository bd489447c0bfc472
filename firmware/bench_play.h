// What the frames of a show take in real time, as a share of the display's period.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>

#include "firmware/loop_counts.h"
#include "firmware/percentile.h"
#include "firmware/show.h"

namespace cupola {

struct PlayBench {
  LoopCounts counts;
  Percentiles work_ms{{}};  // of a frame: from the request for its faces to the last pixel
  double period_ms = 0.0;
};

// Plays the show for `time` on a display that is memory and flips at the rate of the first cue, as `machine`
// in the show has it; what the machine refuses goes to standard error. With `whole`, every pixel of every
// frame is warped, though little of the faces changes.
PlayBench measure_play(const Show& show, std::chrono::nanoseconds time, bool whole, Cpu cpu, WorkerPool& pool,
                       TableCache* cache);

}  // namespace cupola
