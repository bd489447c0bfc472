// What check says of a rig whose cameras are not in one place.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "firmware/rig_cameras.h"
#include "pipeline/optics/rig.h"

namespace cupola {

// Prints where the rig's seams close and how far apart things at other distances are shown there; nothing for
// views that are all in the rig's centre. Sizes that the views have not are those that their cameras are
// asked for.
void print_parallax(const Rig& rig, std::span<const RigCamera> cameras);

}  // namespace cupola
