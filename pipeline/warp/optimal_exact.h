// The reference of the least-squares weights: every pixel its own dense system, filled by plain numerical
// integration. Very slow.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/optics/rig.h"
#include "pipeline/warp/tap.h"

namespace cupola {

// The taps of a pixel that looks along `looking`, which projects to `at` in view `home`, in no order and a
// texel maybe several times. They sum to 1, or less where no view covers a part of the window.
std::vector<Tap> optimal_exact(const Rig& rig, int home, const DirectionAndSlope& looking,
                               const ViewSample& at);

}  // namespace cupola
