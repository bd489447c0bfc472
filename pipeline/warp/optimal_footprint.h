// The texels of one output pixel under least squares: within one view, across seams, and for footprints of
// any size.
//
// The window lies in the home view's plane, which goes on beyond the view's picture. What it wants of a texel
// that another view owns is that texel's own least-squares estimate from the other view's texels, the texel
// being a parallelogram there like any pixel. Where no view covers, the texels that exist are normalised.
//
// Pixels whose box is over 7.6 texels a side fade to the share of each texel that they cover, the limit of
// least squares, and are nothing else from 9.6.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/optics/rig.h"
#include "pipeline/warp/least_squares.h"
#include "pipeline/warp/tap.h"

namespace cupola {

// const after construction, so that threads may share it.
class OptimalFootprint {
 public:
  explicit OptimalFootprint(const Rig& rig) : rig_(rig), solver_(rig.filter.noise) {}  // borrowed

  // Adds the taps of the pixel that looks along `looking`, which projects to `at` in view `home`. Weights sum
  // to 1 but for rounding; each texel comes once.
  void gather(int home, const DirectionAndSlope& looking, const ViewSample& at, std::vector<Tap>& taps) const;

 private:
  void add_least_squares(int home, const Vec3& direction, const ViewSample& at, const PixelArea& area,
                         std::vector<Tap>& taps) const;
  void add_coverage(int home, const Vec3& direction, const ViewSample& at, const PixelArea& area,
                    std::vector<Tap>& taps) const;
  // Adds `weight` times the estimate of a texel of another view's plane from the texels of `view`.
  void add_estimate(int view, const PixelArea& texel, double weight, std::vector<Tap>& taps) const;

  const Rig& rig_;
  LeastSquares solver_;
};

}  // namespace cupola
