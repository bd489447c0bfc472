// An output pixel as a parallelogram in a view's plane, and the windows of texels about it.
// SPDX-License-Identifier: MIT
#pragma once

namespace cupola {

// Texels: the centre (u, v), and the sides (ux, vx) of a step to the right and (uy, vy) of one downward.
struct PixelArea {
  double u, v;
  double ux, uy, vx, vy;
};

// Texels [x, x + width) x [y, y + height).
struct TexelWindow {
  int x, y, width, height;
};

}  // namespace cupola
