// The methods beside the table: the reference, the 1986 scan, other filters and plain samplers.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "pipeline/warp/frame_warp.h"

namespace cupola {

std::unique_ptr<FrameWarp> make_exact_warp(const Rig& rig, WorkerPool& pool);
std::unique_ptr<FrameWarp> make_point_warp(const Rig& rig, Method method,
                                           WorkerPool& pool);  // kNearest, kBilinear
std::unique_ptr<FrameWarp> make_scan_warp(const Rig& rig, Method method, WorkerPool& pool);  // kEwaScan...
std::unique_ptr<FrameWarp> make_pyramid_warp(const Rig& rig, Method method,
                                             WorkerPool& pool);  // kEwaPyramid, kTrilinear
std::unique_ptr<FrameWarp> make_summed_area_warp(const Rig& rig, WorkerPool& pool);
std::unique_ptr<FrameWarp> make_two_pass_warp(const Rig& rig, WorkerPool& pool);

}  // namespace cupola
