// Whether a table that came from outside keeps warp_table.h's promises.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {

// Of all that kernels take for granted: places, counts, windows within their views, patches within their
// windows. The head must be table_head()'s. Weights are not looked at: wrong ones give wrong pixels and no
// more.
bool is_sound(const WarpTable& table, WorkerPool& pool);

}  // namespace cupola
