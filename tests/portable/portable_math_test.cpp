// The portable functions against the C library's in long double.
// SPDX-License-Identifier: MIT
#include "pipeline/portable/portable_math.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace cupola::portable {
namespace {

constexpr double kBound = 1e-15;

double relative(double value, long double truth) {
  return static_cast<double>(std::abs((value - truth) / truth));
}

class PortableMath : public testing::Test {
 protected:
  double uniform(double low, double high) { return std::uniform_real_distribution<>(low, high)(random_); }
  std::mt19937_64 random_{1};
};

TEST_F(PortableMath, SineAndCosineAreRightToTheLastBitsNearAndFar) {
  for (int i = 0; i < 200000; ++i) {
    const double x = uniform(-1.0, 1.0) * (i % 2 == 0 ? 7.0 : 1e5);
    const auto [sine, cosine] = sine_cosine(x);
    ASSERT_NEAR(sine, static_cast<double>(std::sin(static_cast<long double>(x))), kBound);
    ASSERT_NEAR(cosine, static_cast<double>(std::cos(static_cast<long double>(x))), kBound);
  }
}

TEST_F(PortableMath, AnglesAreRightInAllQuadrants) {
  for (int i = 0; i < 200000; ++i) {
    const double y = uniform(-1.0, 1.0);
    const double x = uniform(-1.0, 1.0);
    ASSERT_LT(relative(arc_tangent2(y, x), std::atan2(static_cast<long double>(y), x)), kBound);
    ASSERT_LT(relative(arc_sine(x), std::asin(static_cast<long double>(x))), kBound);
  }
  EXPECT_EQ(arc_tangent2(0.0, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(arc_tangent2(1.0, 0.0), kPi / 2);
  EXPECT_DOUBLE_EQ(arc_tangent2(0.0, -1.0), kPi);
  EXPECT_TRUE(std::isnan(arc_sine(1.0000001)));
}

TEST_F(PortableMath, ExponentialIsRight) {
  for (int i = 0; i < 200000; ++i) {
    const double x = uniform(-600.0, 600.0);
    ASSERT_LT(relative(exponential(x), std::exp(static_cast<long double>(x))), kBound);
  }
  EXPECT_EQ(exponential(0.0), 1.0);
  EXPECT_EQ(exponential(-701.0), 0.0);
}

TEST_F(PortableMath, LogarithmAndPowerAreRight) {
  for (int i = 0; i < 200000; ++i) {
    const double x = i % 2 == 0 ? uniform(0.5, 2.0) : std::exp(uniform(-600.0, 600.0));
    const long double truth = std::log(static_cast<long double>(x));
    ASSERT_NEAR(logarithm(x), static_cast<double>(truth),
                kBound * std::max(1.0, static_cast<double>(std::abs(truth))));
    const double base = uniform(0.0, 100.0);
    const double exponent = uniform(0.1, 3.0);
    ASSERT_LT(relative(power(base, exponent), std::pow(static_cast<long double>(base), exponent)), 2e-14);
  }
  EXPECT_EQ(logarithm(1.0), 0.0);
  EXPECT_EQ(power(0.0, 0.5), 0.0);
}

TEST_F(PortableMath, BesselJ1IsRight) {
  for (int i = 0; i < 20000; ++i) {
    const double x = uniform(-1.0, 1.0) * (i % 3 == 0 ? 2.0 : 100.0);
    const auto truth = static_cast<double>(std::cyl_bessel_jl(1.0L, std::abs(x)));
    ASSERT_NEAR(bessel_j1(x), std::copysign(1.0, x) * truth, kBound) << x;
  }
  EXPECT_EQ(bessel_j1(0.0), 0.0);
}

}  // namespace
}  // namespace cupola::portable
