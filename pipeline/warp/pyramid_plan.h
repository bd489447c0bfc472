// Which texels of which pyramid levels make each pixel: found once, executed by the pyramid warp.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/pyramid.h"
#include "pipeline/warp/tap_runs.h"

namespace cupola {

struct PyramidPlan {
  PyramidShape shape;
  TapRuns taps;  // their images are the pyramid's
};

// The texels of every image of the pyramid that the taps name.
std::vector<TexelSpans> texels_used(const PyramidShape& shape, const TapRuns& taps);

// EWA on the smallest level that can still carry the pixel's ellipse, faded into the next larger one where
// the choice changes (Greene & Heckbert 1986, "Areas for future work").
// With the default Gaussian in place of a kernel with lobes.
PyramidPlan plan_ewa_pyramid(const Rig& rig, WorkerPool& pool);

// Bilinear in two levels of box-filtered copies, interpolated between them (Williams 1983).
PyramidPlan plan_trilinear(const Rig& rig, WorkerPool& pool);

}  // namespace cupola
