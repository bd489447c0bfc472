// Integer weights: exact sums, nearness, and what is refused.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/quantise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

namespace cupola {
namespace {

std::vector<Tap> taps_of(std::vector<double> weights) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<Tap> taps;
  for (const double weight : weights) taps.push_back({static_cast<int>(taps.size()), 0, 0, weight / sum});
  return taps;
}

TEST(Quantise, SumsExactlyAndStaysWithinOneOfTheRealWeight) {
  std::mt19937 random(1);
  std::vector<int> integers;
  for (int i = 0; i < 20000; ++i) {
    const int count = std::uniform_int_distribution<>(2, i % 10 == 0 ? 2000 : 60)(random);
    std::vector<double> weights(count);
    for (double& weight : weights) weight = std::exp(std::uniform_real_distribution<>(-6, 0)(random));
    const std::vector<Tap> taps = taps_of(weights);
    const int total = i % 2 == 0 ? 256 : 8192;
    ASSERT_TRUE(quantise(taps, total, total, integers));
    ASSERT_EQ(std::accumulate(integers.begin(), integers.end(), 0), total);
    for (int k = 0; k < count; ++k) {
      ASSERT_GE(integers[k], 0);
      ASSERT_LT(std::abs(integers[k] - taps[k].weight * total), 1.0 + 1e-9);
    }
  }
}

TEST(Quantise, NegativeWeightsAreRoundedLikeOthers) {
  std::mt19937 random(2);
  std::vector<int> integers;
  for (int i = 0; i < 5000; ++i) {
    std::vector<double> weights(std::uniform_int_distribution<>(2, i % 10 == 0 ? 500 : 60)(random));
    for (double& weight : weights) weight = std::uniform_real_distribution<>(-0.2, 1.0)(random);
    weights[0] = 1.0;
    const std::vector<Tap> taps = taps_of(weights);
    ASSERT_TRUE(quantise(taps, 4096, 8192, integers));
    ASSERT_EQ(std::accumulate(integers.begin(), integers.end(), 0), 4096);
    for (std::size_t k = 0; k < weights.size(); ++k) {
      ASSERT_LT(std::abs(integers[k] - taps[k].weight * 4096), 1.0 + 1e-9);
    }
  }
}

// What the four pictures of period two see: an even colour, both stripes and the checkerboard.
TEST(Quantise, StripesAndCheckerboardsAreOffByNoMoreThanTheirBounds) {
  std::mt19937 random(3);
  std::vector<int> integers;
  for (int i = 0; i < 5000; ++i) {
    const int columns = std::uniform_int_distribution<>(2, i % 10 == 0 ? 60 : 7)(random);
    const int rows = std::uniform_int_distribution<>(1, i % 10 == 0 ? 60 : 7)(random);
    const double least = i % 3 == 0 ? -0.2 : 0.0;
    std::vector<Tap> taps;
    double sum = 0.0;
    for (int k = 0; k < columns * rows; ++k) {
      const double weight = k == 0 ? 1.0 : std::uniform_real_distribution<>(least, 1.0)(random);
      taps.push_back({17 + k % columns, 4 + k / columns, 0, weight});
      sum += taps.back().weight;
    }
    for (Tap& tap : taps) tap.weight /= sum;
    for (const int total : {128, 1024, 8192}) {
      ASSERT_TRUE(quantise(taps, total, 2 * total, integers));
      double checkerboard = 0.0;
      double stripes = 0.0;
      double lines = 0.0;
      for (std::size_t k = 0; k < taps.size(); ++k) {
        const double off = integers[k] - taps[k].weight * total;
        const double along_x = taps[k].x % 2 == 0 ? off : -off;
        stripes += along_x;
        lines += taps[k].y % 2 == 0 ? off : -off;
        checkerboard += taps[k].y % 2 == 0 ? along_x : -along_x;
        ASSERT_TRUE(least < 0.0 || integers[k] >= 0);
      }
      ASSERT_LE(std::abs(checkerboard), 1.0 + 1e-9);
      ASSERT_LE(std::abs(stripes), 2.0 + 1e-9);
      ASSERT_LE(std::abs(lines), 2.0 + 1e-9);
    }
  }
}

TEST(Quantise, RealWeightsThatAreWholeStayAsTheyAre) {
  std::vector<int> integers;
  ASSERT_TRUE(quantise(taps_of({1, 2, 1}), 256, 255, integers));
  EXPECT_EQ(integers, (std::vector<int>{64, 128, 64}));
}

TEST(Quantise, OneStepTooManyGoesToTheNextHeaviestTap) {
  std::vector<int> integers;
  ASSERT_TRUE(quantise(taps_of({0.999, 0.0006, 0.0004}), 256, 255, integers));
  EXPECT_EQ(integers, (std::vector<int>{255, 1, 0}));
}

TEST(Quantise, ASingleTapNeedsAllOfTheTotal) {
  std::vector<int> integers;
  EXPECT_FALSE(quantise(taps_of({1}), 256, 255, integers));
  EXPECT_TRUE(quantise(taps_of({1}), 8192, 8192, integers));
  EXPECT_FALSE(quantise(taps_of({0.6, 0.4}), 512, 255, integers)) << "bending the filter is not rounding";
}

TEST(Quantise, WideFlatFootprintsKeepTheirShape) {
  // 20,000 taps of less than half a step each: every run of 100 taps must still weigh its share, its even and
  // its odd ones to a step each.
  std::vector<int> integers;
  ASSERT_TRUE(quantise(taps_of(std::vector<double>(20000, 1.0)), 8192, 8192, integers));
  for (int i = 0; i < 20000; i += 100) {
    EXPECT_NEAR(std::accumulate(integers.begin() + i, integers.begin() + i + 100, 0), 40.96, 2.0);
  }
}

}  // namespace
}  // namespace cupola
