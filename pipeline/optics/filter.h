// The resampling filter's settings, as a rig file gives them.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace cupola {

// The first three are k(s), s = sqrt q in output pixels; their weights are normalised.
enum class Kernel : std::uint8_t {
  kGaussian,  // exp(-alpha s^2) (Greene & Heckbert 1986, figure 9)
  kRobidoux,  // the cubic of Mitchell & Netravali with B = 0.3782, C = 0.3109; 0 from s = 2
  kJinc,      // 2 J1(pi s) / (pi s), windowed by its own main lobe stretched to `radius`
  kOptimal,   // no kernel: least squares, see pipeline/warp/least_squares.h
};

// How many bits the warp table's weights have, and how it is kept.
enum class TableForm : std::uint8_t {
  kFast,     // weights of a pixel sum to 2^8 to 2^10; wide footprints as kPrecise
  kPrecise,  // weights of a pixel sum to 2^13
  kCompact,  // kFast in memory, packed where it is stored (pipeline/warp/table_packing.h)
};

inline constexpr double kDefaultNoise = 1e-3;

struct FilterSettings {
  // The defaults are the best Gaussian of docs/performance.md: alpha 6 has the variance of a box pixel.
  Kernel kernel = Kernel::kGaussian;
  double alpha = 6.0;   // kGaussian: > 0
  double radius = 1.0;  // output pixels, > 0; not of kOptimal
  double rec = 0.5;     // texels^2 added to the ellipse to reconstruct: 0 in 1986, 1 with Heckbert in 1989
  TableForm table = TableForm::kFast;
  double noise = kDefaultNoise;  // kOptimal: variance of noise in a texel, as a share of the picture's
};

// What samples mean to the filter, and how they are narrowed. No bearing on weights.
struct SampleSettings {
  bool linear_light = false;  // samples are sRGB: filtered as light, not as they are encoded
  bool dither = true;         // from more than 8 bits to 8
};

inline FilterSettings default_gaussian() {
  return {Kernel::kGaussian, 6.0, 1.0, 0.5, TableForm::kFast};
}

// "paper": gaussian, alpha 2, radius 2, rec 0.
inline FilterSettings paper_preset() {
  return {Kernel::kGaussian, 2.0, 2.0, 0.0, TableForm::kFast};
}

// The other kernels with their own radii: 2, and the jinc's third zero.
inline FilterSettings robidoux_filter() {
  return {Kernel::kRobidoux, 6.0, 2.0, 0.0, TableForm::kFast};
}
inline FilterSettings jinc_filter() {
  return {Kernel::kJinc, 6.0, 3.2383154841662362, 0.0, TableForm::kFast};
}

inline FilterSettings optimal_filter(double noise = kDefaultNoise) {
  return {Kernel::kOptimal, 6.0, 1.0, 0.5, TableForm::kFast, noise};
}

// Singular values of the Jacobian below this many texels a pixel are raised to it: so that no footprint is
// empty, and for kernels with lobes, which reconstruct as well, so that none is narrower than the texels are
// apart.
inline double smallest_axis(const FilterSettings& filter) {
  return filter.kernel == Kernel::kGaussian ? 0.75 / filter.radius : 1.0;
}

// Negative lobes can outweigh the rest where a footprint is cut off by the edge of all views. A footprint
// whose weights sum to less than this share of their absolute values drops the negative ones, so that no
// normalised weight leaves [-1, 2].
inline constexpr double kLeastSignedShare = 1.0 / 3.0;

}  // namespace cupola
