// Lens models: the angle from the axis of projection as a function of the distance from the image's centre.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace cupola {

class SettingsTable;

enum class LensModel : std::uint8_t {
  kPolynomial,     // phi = c0 + c1 r + c2 r^2 ..., radians; c0 = 0. "omnimax-c430" is one
  kEquidistant,    // phi = fov / 2 * r
  kEquisolid,      // phi = 2 asin(r sin(fov / 4))
  kStereographic,  // phi = 2 atan(r tan(fov / 4))
  kOrthographic,   // phi = asin(r sin(fov / 2)); fov at most 180 degrees
  kOpencvFisheye,  // r = g(phi) / g(fov / 2), g(phi) = phi (1 + k1 phi^2 + k2 phi^4 + k3 phi^6 + k4 phi^8)
};

// Rises strictly from phi(0) = 0 to phi(1): lenses made by the functions below are checked for that.
struct Lens {
  LensModel model = LensModel::kEquidistant;
  double half_fov = 0.0;             // phi(1), radians, for all but kPolynomial
  std::vector<double> coefficients;  // c0, c1, ... or k1 ... k4
  std::string name;
};

struct LensSample {
  double phi;    // radians from the axis
  double slope;  // d phi / d r, radians
};

// Greene & Heckbert 1986, after Max 1983: phi = 1.411269 r - 0.094389 r^3 + 0.25674 r^5.
Lens omnimax_c430();
Lens equidistant(double fov_degrees);

// `r` from 0 to 1.
LensSample sample(const Lens& lens, double r);
// The inverse: r for an angle from 0 to phi(1); found to 1e-14.
double radius_at(const Lens& lens, double phi);

// What is wrong with a lens made by hand, empty when nothing is: not finite, off the axis, folding (with the
// radius where it does), past the opposite direction.
std::string fault(const Lens& lens);

// Reads a [lens] table: model and its keys, or file = "NAME", looked for beside `directory`, then in
// config/lenses. Throws InputError; a lens that folds is refused with the radius where it does.
Lens read_lens(SettingsTable& table, const std::filesystem::path& directory);

}  // namespace cupola
