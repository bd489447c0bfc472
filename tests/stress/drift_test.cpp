// How far finite differences drift from the quadratic they walk along; docs/performance.md has the table.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "pipeline/warp/quadratic_scan.h"
#include "tests/stress/random_rigs.h"

namespace cupola {
namespace {

constexpr double kEntries = 4096.0;  // the weight table of scan_warp.cpp; Q is in its entries

template <class Number>
double value_of(Number q) {
  return std::is_integral_v<Number> ? std::ldexp(static_cast<double>(q), -kScanFractionBits)
                                    : static_cast<double>(q);
}

// The largest error of Q within footprints whose boxes are `side` texels wide and high, in entries. The
// ellipses touch the box's sides, their axes differ up to tenfold and stand at any angle.
template <class Number>
double drift(int side) {
  test::Dice dice(static_cast<std::uint64_t>(side));
  double most = 0.0;
  for (int i = 0; i < (side < 1024 ? 24 : 3); ++i) {
    const double angle = dice.real(0.0, 3.14);
    const double aspect = dice.log_uniform(1.0, 10.0);
    // The covariance, scaled to the box and so that Q is kEntries on the ellipse.
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    double uu = c * c * aspect * aspect + s * s;
    double vv = s * s * aspect * aspect + c * c;
    double uv = c * s * (aspect * aspect - 1.0);
    const double scale = side * side / 4.0 / std::max(uu, vv);
    uu *= scale;
    vv *= scale;
    uv *= scale;
    const double f = (uu * vv - uv * uv) / kEntries;
    const double qa = vv / f;
    const double qb = -2.0 * uv / f;
    const double qc = uu / f;
    const double u0 = -std::sqrt(uu) + dice.real(0.0, 1.0);
    const double v0 = -std::sqrt(vv) + dice.real(0.0, 1.0);
    auto row = scan_from<Number>(qa, qb, qc, u0, v0);
    const int rows = static_cast<int>(2.0 * std::sqrt(vv));
    const int columns = static_cast<int>(2.0 * std::sqrt(uu));
    for (int y = 0; y < rows; ++y, row.down()) {
      auto at = row;
      const double v = v0 + y;
      for (int x = 0; x < columns; ++x, at.right()) {
        const double u = u0 + x;
        const double exact = qa * u * u + qb * u * v + qc * v * v;
        if (exact < kEntries) most = std::max(most, std::abs(value_of(at.q) - exact));
      }
    }
  }
  return most;
}

TEST(ScanDrift, StaysWithinItsBoundsOverRunsOf8To4096Texels) {
  std::printf("run (texels)   float   integer   bound (entries of %g)\n", kEntries);
  for (int side = 8; side <= 4096; side *= 2) {
    const double in_float = drift<float>(side);
    const double in_integers = drift<std::int64_t>(side);
    // (n + m)^2 / 2^21 + n m / 2^21 with n = m = side.
    const double bound = 5.0 * side * side * std::ldexp(1.0, -21);
    std::printf("%12d %9.4f %9.6f %9.4f\n", side, in_float, in_integers, bound);
    EXPECT_LE(in_integers, bound + 1e-6) << side;
    EXPECT_LE(in_float, 0.02 * side + 1.0) << side;
  }
}

}  // namespace
}  // namespace cupola
