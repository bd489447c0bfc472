// The texels of one output pixel and their weights, as the table builder needs them: fast, portable, exact.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/optics/portable_math.h"
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
  explicit FootprintGatherer(const Rig& rig) : rig_(rig) {}  // borrowed

  // Fills `taps` with the footprint of pixel (x, y), view by view, row by row, from left to right; the
  // weights are above 0 and sum to 1.
  Footprint gather(int x, int y, std::vector<Tap>& taps) const;

 private:
  struct Ellipse;

  // Whether `home` alone feeds all directions of the ellipse's box, which lie within `cone` of `direction`.
  bool owns_whole_box(int home, const Vec3& direction, const Ellipse& ellipse,
                      const portable::SineCosine& cone) const;
  void gather_inside(int view, const Ellipse& ellipse, std::vector<Tap>& taps) const;
  void gather_across_seams(int home, const Vec3& direction, const Ellipse& ellipse, double angle,
                           std::vector<Tap>& taps) const;

  const Rig& rig_;
};

}  // namespace cupola
