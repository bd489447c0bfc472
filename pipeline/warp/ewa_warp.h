// The warp the player uses: a table built once, executed by the fastest kernel, tile by tile over the pool.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "pipeline/optics/filter.h"
#include "pipeline/warp/frame_warp.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {

// `table` is borrowed for the warp's life, as is `pool`.
std::unique_ptr<FrameWarp> make_table_warp(const WarpTable& table, Cpu cpu, WorkerPool& pool,
                                           const SampleSettings& samples = {});

}  // namespace cupola
