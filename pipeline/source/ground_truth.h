// What a perfect renderer would show: worlds averaged over the pixels of a frame, straight from their
// formulas.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/optics/frame_geometry.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/source/world.h"

namespace cupola {

// Planes R, G, B, row by row, 0 to 255, unrounded. Each pixel in the image is the mean over
// samples_per_side^2 rays, evenly spread, those outside the image left out; others are 0.
std::vector<double> render_truth_exact(const FrameGeometry& frame, const Mat3& world_from_lens,
                                       const World& world, double seconds, int samples_per_side,
                                       WorkerPool& pool);
// The same rounded, kRgbPlanar8.
ImageBuffer render_truth(const FrameGeometry& frame, const Mat3& world_from_lens, const World& world,
                         double seconds, int samples_per_side, WorkerPool& pool);

// The mean colour, 0 to 1, over a w x h rectangle of a view's plane whose top-left corner is `corner`;
// texels. `view` has a pose in the world's own space.
Vec3 mean_over(const View& view, const Vec2& corner, const Vec2& extent, const Instant& instant,
               int samples_per_side);

}  // namespace cupola
