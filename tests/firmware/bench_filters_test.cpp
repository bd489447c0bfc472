// What the benches say of the filters, at sizes small enough for every run of the tests.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "firmware/bench_stars.h"
#include "firmware/bench_warp.h"

namespace cupola {
namespace {

TEST(BenchOfFilters, LeastSquaresWeightsKeepAStarsLightBetterThanBilinearAndTheDefaultGaussian) {
  WorkerPool pool(2);
  const std::vector<StarRow> rows = measure_stars({{"optimal", Method::kEwa, optimal_filter()},
                                                   {"bilinear", Method::kBilinear, {}},
                                                   {"gaussian", Method::kEwa, default_gaussian()}},
                                                  150, pool);
  int grounds = 0;
  const StarRow* optimal = nullptr;
  for (const StarRow& row : rows) {
    if (row.contender == "optimal") {
      optimal = &row;
      ++grounds;
    }
    if (row.contender == "bilinear" || row.contender == "gaussian") {
      EXPECT_LT(optimal->mean_variation, row.mean_variation) << row.contender << row.ground;
      EXPECT_LT(optimal->worst_swing, row.worst_swing) << row.contender << row.ground;
    }
  }
  EXPECT_EQ(grounds, 2);
}

TEST(BenchOfFilters, LeastSquaresWeightsComeNearestToTheTruth) {
  WorkerPool pool(2);
  const Quality quality = measure_quality({{"optimal", Method::kEwa, optimal_filter()},
                                           {"gaussian", Method::kEwa, default_gaussian()},
                                           {"robidoux", Method::kEwa, robidoux_filter()},
                                           {"bilinear", Method::kBilinear, {}}},
                                          {"rotated-checker"}, 120, pool);
  // Which peers are measured with them depends on what was there when this was built.
  int scales = 0;
  for (const QualityRow& best : quality.rows) {
    if (best.contender != "optimal") {
      continue;
    }
    ++scales;
    for (const QualityRow& other : quality.rows) {
      if (other.minification == best.minification && other.contender != best.contender) {
        EXPECT_GT(best.psnr_db[0], other.psnr_db[0]) << other.contender << ' ' << other.minification;
      }
    }
  }
  EXPECT_EQ(scales, 3);
}

}  // namespace
}  // namespace cupola
