// How much of a texel a pixel's parallelogram covers: the weights of footprints too wide for least squares.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/warp/pixel_area.h"

namespace cupola {

// `area` about its own centre with both singular values raised to at least one texel, so that it always
// covers something and never has a visible grain.
class Coverage {
 public:
  explicit Coverage(const PixelArea& area);

  // Texels^2, 0 to 1, for the texel whose centre lies (du, dv) from the area's.
  double operator()(double du, double dv) const;

  // Of the box of all covered texels' centres.
  double half_width() const;
  double half_height() const;

 private:
  double ux_, uy_, vx_, vy_;
  double to_x_u_, to_x_v_, to_y_u_, to_y_v_;  // the inverse: pixels a texel
};

}  // namespace cupola
