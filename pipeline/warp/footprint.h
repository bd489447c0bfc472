// The texels of one output pixel and their weights, as the table builder needs them: fast, portable, exact.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pipeline/optics/rig.h"
#include "pipeline/warp/optimal_footprint.h"
#include "pipeline/warp/radial_kernel.h"
#include "pipeline/warp/tap.h"

namespace cupola {

enum class Footprint : std::uint8_t {
  kOutside,    // the pixel is not in the image
  kUncovered,  // it is, but no view covers its ray
  kCovered,
};

// Gathers footprints for one rig; const after construction, so that threads may share it.
class FootprintGatherer {
 public:
  explicit FootprintGatherer(const Rig& rig);  // borrowed

  // Fills `taps` with the footprint of pixel (x, y), view by view, row by row, from left to right. The
  // weights, some of which may be negative with other kernels than the Gaussian, lie in [-1, 2] and sum to 1.
  // A footprint of more than kMostTaps texels is given up half-way, with more taps than that.
  Footprint gather(int x, int y, std::vector<Tap>& taps) const;

 private:
  struct Ellipse;

  Footprint gather_home(const DirectionAndSlope& looking, std::vector<Tap>& taps) const;
  void gather_feathered(const DirectionAndSlope& looking, std::span<const double> shares,
                        std::vector<Tap>& taps) const;
  void gather_ellipse(int home, const DirectionAndSlope& looking, const ViewSample& at,
                      std::vector<Tap>& taps) const;
  void gather_inside(int view, const Ellipse& ellipse, std::vector<Tap>& taps) const;

  const Rig& rig_;
  RadialKernel kernel_;
  Feather feather_;
  // Where views mix, each one's footprint is that of a rig which has no other view.
  std::vector<std::unique_ptr<const Rig>> alone_rigs_;
  std::vector<std::unique_ptr<const FootprintGatherer>> alone_;
  std::unique_ptr<OptimalFootprint> optimal_;  // null for kernels of q
};

}  // namespace cupola
