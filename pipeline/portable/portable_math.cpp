// Series evaluated after range reduction; every constant is exact or correctly rounded.
// SPDX-License-Identifier: MIT
#include "pipeline/portable/portable_math.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace cupola::portable {
namespace {

// pi / 2 in three parts; the first two have 33 significant bits, so that n times either is exact for |n| <
// 2^20.
constexpr double kHalfPiHigh = 0x1.921fb544p+0;
constexpr double kHalfPiMiddle = 0x1.0b4611a6p-34;
constexpr double kHalfPiLow = 0x1.3198a2e037073p-69;

// ln 2 in two parts, the first with 33 significant bits.
constexpr double kLn2High = 0x1.62e42feep-1;
constexpr double kLn2Low = 0x1.a39ef35793c76p-33;

// 1 / n, correctly rounded, so that the series need no division; [0] is unused.
constexpr std::array<double, 24> kOneOver = [] {
  std::array<double, 24> table{};
  for (int n = 1; n < 24; ++n) table[n] = 1.0 / n;
  return table;
}();

// Sum of 1 / n! terms for |x| <= pi / 4: the first term left out is below 1e-18 of the result.
double sine_series(double x) {
  const double y = x * x;
  double sum = 1.0;
  for (int n = 16; n >= 2; n -= 2) sum = 1.0 - sum * y * (kOneOver[n] * kOneOver[n + 1]);
  return x * sum;
}

double cosine_series(double x) {
  const double y = x * x;
  double sum = 1.0;
  for (int n = 17; n >= 3; n -= 2) sum = 1.0 - sum * y * (kOneOver[n] * kOneOver[n + 1]);
  return 1.0 - 0.5 * y * sum;
}

// atan for 0 <= x <= 1. One halving of the angle brings x below tan(pi / 8), another below tan(pi / 16).
double arc_tangent_unit(double x) {
  x = x / (1.0 + std::sqrt(1.0 + x * x));
  x = x / (1.0 + std::sqrt(1.0 + x * x));
  const double y = x * x;
  double sum = 0.0;
  for (int n = 23; n >= 1; n -= 2) sum = kOneOver[n] - y * sum;
  return 4.0 * x * sum;
}

}  // namespace

SineCosine sine_cosine(double radians) {
  const double n = std::nearbyint(radians * (2.0 / kPi));
  const double x = ((radians - n * kHalfPiHigh) - n * kHalfPiMiddle) - n * kHalfPiLow;
  const double sine = sine_series(x);
  const double cosine = cosine_series(x);
  switch (static_cast<long long>(n) & 3) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

double tangent(double radians) {
  const SineCosine both = sine_cosine(radians);
  return both.sine / both.cosine;
}

double arc_tangent2(double y, double x) {
  const double ay = std::abs(y);
  const double ax = std::abs(x);
  if (ax == 0.0 && ay == 0.0) return 0.0;
  double angle = ay <= ax ? arc_tangent_unit(ay / ax) : kPi / 2 - arc_tangent_unit(ax / ay);
  if (x < 0.0) angle = kPi - angle;
  return y < 0.0 ? -angle : angle;
}

double arc_sine(double x) {
  if (!(x >= -1.0 && x <= 1.0)) return std::numeric_limits<double>::quiet_NaN();
  return arc_tangent2(x, std::sqrt((1.0 - x) * (1.0 + x)));
}

double exponential(double x) {
  if (x < -700.0) return 0.0;
  if (x > 700.0) x = 700.0;
  constexpr double kToInteger = 0x1.8p52;  // added, it leaves no bits for a fraction: rounded to even
  const double n = (x * 1.4426950408889634 + kToInteger) - kToInteger;
  const double r = (x - n * kLn2High) - n * kLn2Low;  // |r| <= ln 2 / 2
  double sum = 1.0;
  for (int i = 14; i >= 1; --i) sum = 1.0 + sum * r * kOneOver[i];
  // |n| is at most 1010: 2^n and the product are exact.
  return sum * std::bit_cast<double>(static_cast<std::uint64_t>(static_cast<int>(n) + 1023) << 52);
}

// x = 2^n m with m from sqrt(1/2) to sqrt(2); ln m = 2 artanh((m - 1) / (m + 1)), argument below 0.172.
double logarithm(double x) {
  constexpr double kRootHalf = 0.70710678118654752;
  int n = 0;
  double m = std::frexp(x, &n);
  if (m < kRootHalf) {
    m *= 2.0;
    --n;
  }
  const double s = (m - 1.0) / (m + 1.0);
  const double y = s * s;
  double sum = 0.0;
  for (int i = 23; i >= 1; i -= 2) sum = kOneOver[i] + y * sum;
  return n * kLn2High + (n * kLn2Low + 2.0 * s * sum);
}

double power(double x, double y) {
  return x > 0.0 ? exponential(y * logarithm(x)) : 0.0;
}

// Near 0 the power series. Beyond, Miller's downward recurrence J[n-1] = 2 n / x J[n] - J[n+1] from where J
// is below 1e-19 of its largest, scaled by J0 + 2 (J2 + J4 + ...) = 1.
double bessel_j1(double x) {
  const double a = std::abs(x);
  if (a < 1.0) {
    const double y = x * x / 4.0;
    double sum = 1.0;
    for (int n = 9; n >= 1; --n) sum = 1.0 - sum * y * (kOneOver[n] * kOneOver[n + 1]);
    return x / 2.0 * sum;
  }
  double above = 0.0;
  double here = 1e-250;
  double even = 0.0;  // J2 + J4 + ...
  for (int n = 2 * (static_cast<int>(a + 60.0) / 2); n >= 2; --n) {
    if (n % 2 == 0) even += here;
    const double below = 2.0 * n / a * here - above;
    above = here;
    here = below;
  }
  const double j0 = 2.0 / a * here - above;
  const double value = here / (j0 + 2.0 * even);
  return x < 0.0 ? -value : value;
}

}  // namespace cupola::portable
