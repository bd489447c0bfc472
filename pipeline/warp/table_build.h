// Builds the warp table of a rig: a pure function, the same bytes on every machine and for every thread
// count.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {

// The rig's views must have sizes. Throws InputError when a footprint has more than kMostTaps texels.
WarpTable build_warp_table(const Rig& rig, WorkerPool& pool);
// With no other mirror images than these, which find_reflections() has found.
WarpTable build_warp_table(const Rig& rig, const std::vector<Reflection>& reflections, WorkerPool& pool);

}  // namespace cupola
