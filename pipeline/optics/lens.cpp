// Lens models, their inverses and the check that a lens does not fold.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

using portable::kPi;

// The arc sine's slope is infinite at 1: rims are taken a hair inside.
constexpr double kRim = 1.0 - 1e-14;

LensSample polynomial(const std::vector<double>& c, double r) {
  double phi = 0.0;
  double slope = 0.0;
  for (std::size_t i = c.size(); i-- > 0;) {
    slope = slope * r + phi;
    phi = phi * r + c[i];
  }
  return {phi, slope};
}

// g(phi) of the OpenCV fisheye model and its derivative.
LensSample opencv_radius(const std::vector<double>& k, double phi) {
  const double y = phi * phi;
  double factor = 0.0;
  double derivative = 0.0;  // of factor by y
  for (std::size_t i = k.size(); i-- > 0;) {
    derivative = derivative * y + factor;
    factor = factor * y + k[i];
  }
  // g = phi (1 + y factor(y))
  return {phi * (1.0 + y * factor), 1.0 + 3.0 * y * factor + 2.0 * y * y * derivative};
}

// Solves f(x) = target for a rising f on [low, high]: Newton steps, halving where one would leave the
// bracket.
template <class Function>
double solve_rising(Function&& f, double target, double low, double high) {
  double x = 0.5 * (low + high);
  for (int i = 0; i < 100; ++i) {
    const auto [value, slope] = f(x);
    (value < target ? low : high) = x;
    double next = x - (value - target) / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - x) < 1e-15) return next;
    x = next;
  }
  return x;
}

// The first of 4097 points from 0 to 1 where the curve has stopped rising, refined by halving; > 1 when
// none.
template <class Slope>
double first_fold(Slope&& slope) {
  constexpr int kSteps = 4096;
  for (int i = 0; i <= kSteps; ++i) {
    double high = static_cast<double>(i) / kSteps;
    if (slope(high) > 0.0) continue;
    double low = std::max(0, i - 1) / static_cast<double>(kSteps);
    for (int k = 0; k < 50; ++k) {
      const double middle = 0.5 * (low + high);
      (slope(middle) > 0.0 ? low : high) = middle;
    }
    return high;
  }
  return 2.0;
}

}  // namespace

LensSample sample(const Lens& lens, double r) {
  switch (lens.model) {
    case LensModel::kPolynomial:
      return polynomial(lens.coefficients, r);
    case LensModel::kEquidistant:
      return {lens.half_fov * r, lens.half_fov};
    case LensModel::kEquisolid: {
      const double s = portable::sine_cosine(lens.half_fov / 2).sine;
      const double x = std::min(kRim, r * s);
      return {2.0 * portable::arc_sine(x), 2.0 * s / std::sqrt((1.0 - x) * (1.0 + x))};
    }
    case LensModel::kStereographic: {
      const double t = portable::tangent(lens.half_fov / 2);
      return {2.0 * portable::arc_tangent2(r * t, 1.0), 2.0 * t / (1.0 + r * r * t * t)};
    }
    case LensModel::kOrthographic: {
      const double s = portable::sine_cosine(lens.half_fov).sine;
      const double x = std::min(kRim, r * s);
      return {portable::arc_sine(x), s / std::sqrt((1.0 - x) * (1.0 + x))};
    }
    case LensModel::kOpencvFisheye: {
      const double rim = opencv_radius(lens.coefficients, lens.half_fov).phi;
      const auto g = [&](double phi) { return opencv_radius(lens.coefficients, phi); };
      const double phi = r <= 0.0 ? 0.0 : solve_rising(g, r * rim, 0.0, lens.half_fov * (1.0 + 1e-12));
      return {phi, rim / g(phi).slope};
    }
  }
  return {0.0, 0.0};
}

double radius_at(const Lens& lens, double phi) {
  if (phi <= 0.0) return 0.0;
  switch (lens.model) {
    case LensModel::kEquidistant:
      return phi / lens.half_fov;
    case LensModel::kEquisolid:
      return portable::sine_cosine(phi / 2).sine / portable::sine_cosine(lens.half_fov / 2).sine;
    case LensModel::kStereographic:
      return portable::tangent(phi / 2) / portable::tangent(lens.half_fov / 2);
    case LensModel::kOrthographic:
      return portable::sine_cosine(phi).sine / portable::sine_cosine(lens.half_fov).sine;
    case LensModel::kOpencvFisheye:
      return opencv_radius(lens.coefficients, phi).phi / opencv_radius(lens.coefficients, lens.half_fov).phi;
    case LensModel::kPolynomial:
      return solve_rising([&](double r) { return sample(lens, r); }, phi, 0.0, 1.0 + 1e-12);
  }
  return 0.0;
}

std::string fault(const Lens& lens) {
  const auto bad = [](double x) { return !std::isfinite(x); };
  if (bad(lens.half_fov) || std::any_of(lens.coefficients.begin(), lens.coefficients.end(), bad)) {
    return "expected finite numbers";
  }
  if (lens.model == LensModel::kPolynomial) {
    if (lens.coefficients.size() < 2 || lens.coefficients[0] != 0.0) {
      return "expected coefficients [0, c1, ...]: the image's centre must lie on the axis";
    }
    const double fold = first_fold([&](double r) { return sample(lens, r).slope; });
    if (fold <= 1.0)
      return fmt::format("the lens folds: phi(r) stops rising at r = {:.6f}, expected it to rise up to r = 1",
                         fold);
    const double rim = sample(lens, 1.0).phi;
    if (rim > kPi) return fmt::format("expected phi(1) of at most pi, not {:.6f}", rim);
  }
  if (lens.model == LensModel::kOpencvFisheye) {
    const auto [rim, slope] = opencv_radius(lens.coefficients, lens.half_fov);
    if (bad(rim) || bad(slope)) return "expected coefficients whose radius at fov_deg / 2 is finite";
    const double fold =
        first_fold([&](double t) { return opencv_radius(lens.coefficients, t * lens.half_fov).slope; });
    if (fold <= 1.0) {
      const double phi = fold * lens.half_fov;
      return fmt::format(
          "the lens folds: its radius stops growing at {:.4f} degrees from the axis (r = {:.6f} of focal "
          "length), "
          "expected it to grow up to fov_deg / 2",
          phi * 180.0 / kPi, opencv_radius(lens.coefficients, phi).phi);
    }
  }
  return {};
}

Lens omnimax_c430() {
  return {LensModel::kPolynomial, 0.0, {0.0, 1.411269, 0.0, -0.094389, 0.0, 0.25674}, "omnimax-c430"};
}

Lens equidistant(double fov_degrees) {
  return {LensModel::kEquidistant, portable::radians(fov_degrees / 2), {}, "equidistant"};
}

}  // namespace cupola
