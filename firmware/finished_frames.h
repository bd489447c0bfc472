// Frames that were made before: they are shown as they are.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/frame_warp.h"

namespace cupola {

// A warp from one face, which is the frame, into the frame. `pool` is borrowed for its life.
std::unique_ptr<FrameWarp> make_finished_frames(Size size, WorkerPool& pool);

}  // namespace cupola
