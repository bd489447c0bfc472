// Which mirror images of the frame a rig repeats itself in; the warp table then stores a half or a quarter.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/optics/rig.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {

// The rig's reflections as WarpTable has them: the frame itself last, alone where there is no symmetry. The
// rig's views must have sizes.
std::vector<Reflection> find_reflections(const Rig& rig);

}  // namespace cupola
