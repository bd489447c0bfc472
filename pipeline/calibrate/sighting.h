// What was seen of the board: its corners in one camera's picture of one shot.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/optics/vector.h"

namespace cupola {

struct Sighting {
  int camera = 0;             // which of the rig's views
  int shot = 0;               // the same moment on all cameras
  std::vector<Vec2> corners;  // texels as in View, in the order of board_corners
  double edge_texels = 0.0;   // from a tenth to nine tenths of a square's edge: how sharp the picture is
};

}  // namespace cupola
