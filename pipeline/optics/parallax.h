// Parallax: how far apart at the seams two views show a thing that is not at the distance where seams close.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/optics/rig.h"

namespace cupola {

struct SeamParallax {
  double radians = 0.0;  // between the two places in the frame where the views show it
  double texels = 0.0;   // of the first view there
  int first = -1;        // the views; -1: there is no seam
  int second = -1;
};

// The largest along all seams of the frame, of things `distance_m` from the rig's centre, which may be
// infinite but no nearer than kLeastSeamDistance positions. The rig's views must have sizes.
SeamParallax parallax_at_seams(const Rig& rig, double distance_m);

}  // namespace cupola
