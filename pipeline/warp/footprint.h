// The texels of one output pixel and their weights, as the table builder needs them: fast, portable, exact.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/optics/rig.h"

namespace cupola {

struct Tap {
  int x, y;  // texel
  int view;
  double weight;
};

enum class Footprint : std::uint8_t {
  kOutside,    // the pixel is not in the image
  kUncovered,  // it is, but no view covers its ray
  kCovered,
};

// Gathers footprints for one rig; const after construction, so that threads may share it.
class FootprintGatherer {
 public:
  explicit FootprintGatherer(const Rig& rig);  // borrowed

  // Fills `taps` with the footprint of pixel (x, y); the weights are above 0 and sum to 1.
  Footprint gather(int x, int y, std::vector<Tap>& taps) const;

 private:
  // Where a view is nearer than any other, in its own plane: a u + b v + c >= 0 for each.
  struct HalfPlane {
    double a, b, c;
  };
  struct Ellipse;

  bool owns_whole_box(std::size_t view, const Ellipse& ellipse) const;
  void gather_inside(int view, const Ellipse& ellipse, std::vector<Tap>& taps) const;
  void gather_across_seams(int home, const Vec3& direction, const ViewSample& at, const Ellipse& ellipse,
                           std::vector<Tap>& taps) const;

  const Rig& rig_;
  std::vector<std::vector<HalfPlane>> borders_;  // one list a view; none for a view that distorts
};

}  // namespace cupola
