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
  for (std::size_t i = 0; i < quality.rows.size(); i += 4) {
    for (std::size_t other = i + 1; other < i + 4; ++other) {
      EXPECT_GT(quality.rows[i].psnr_db[0], quality.rows[other].psnr_db[0])
          << quality.rows[other].contender << ' ' << quality.rows[other].minification;
    }
  }
}

}  // namespace
}  // namespace cupola
