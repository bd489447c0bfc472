// The resampling filter's settings, as a rig file gives them.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace cupola {

enum class Kernel : std::uint8_t {
  kGaussian,  // k(s) = exp(-alpha s^2), s in output pixels (Greene & Heckbert 1986, figure 9)
};

// How many bits the warp table's weights have.
enum class TableForm : std::uint8_t {
  kFast,     // weights of a pixel sum to 2^8 to 2^10; wide footprints as kPrecise
  kPrecise,  // weights of a pixel sum to 2^13
};

struct FilterSettings {
  // The defaults are the best Gaussian of docs/performance.md: alpha 6 has the variance of a box pixel.
  Kernel kernel = Kernel::kGaussian;
  double alpha = 6.0;   // > 0
  double radius = 1.0;  // output pixels, > 0
  double rec = 0.5;     // texels^2 added to the ellipse to reconstruct: 0 in 1986, 1 with Heckbert in 1989
  TableForm table = TableForm::kFast;
};

// "paper": gaussian, alpha 2, radius 2, rec 0.
inline FilterSettings paper_preset() {
  return {Kernel::kGaussian, 2.0, 2.0, 0.0, TableForm::kFast};
}

// Singular values of the Jacobian below this many texels a pixel are raised to it, so that no footprint is
// empty.
inline double smallest_axis(const FilterSettings& filter) {
  return 0.75 / filter.radius;
}

}  // namespace cupola
