// The fit's slopes against differences, and its answers against the truth.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/adjustment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/portable/cholesky.h"
#include "tests/calibrate/simulated_rig.h"

namespace cupola {
namespace {

constexpr Size kSize{600, 600};

TEST(Cholesky, SolvesAndInvertsAndRefusesWhatIsNotDetermined) {
  // [4 2; 2 3] x = [2; 5]: x = [-1/2; 2].
  std::vector<double> matrix = {4, 99, 2, 3};
  ASSERT_TRUE(factorise(matrix, 2));
  std::vector<double> x = {2, 5};
  solve(matrix, 2, x);
  EXPECT_DOUBLE_EQ(x[0], -0.5);
  EXPECT_DOUBLE_EQ(x[1], 2.0);
  invert(matrix, 2);
  EXPECT_DOUBLE_EQ(matrix[0], 0.375);
  EXPECT_DOUBLE_EQ(matrix[1], -0.25);
  EXPECT_DOUBLE_EQ(matrix[2], -0.25);
  EXPECT_DOUBLE_EQ(matrix[3], 0.5);
  std::vector<double> singular = {1, 0, 1, 1};
  EXPECT_FALSE(factorise(singular, 2));
}

TEST(CameraSlopes, AreThoseThatSmallChangesMake) {
  const SimulatedCamera camera = simulated_cameras(kSize)[3];
  const Vec3 point = camera.place + 0.7 * camera.view.forward + Vec3{0.2, 0.05, -0.3};
  Vec2 here;
  std::array<Vec2, kCameraParameters> slopes{};
  ASSERT_TRUE(camera_slopes(camera.view, point - camera.place, here, slopes));
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    Vec3 by{0.0};
    by[i % 3] = kStep;
    View moved = camera.view;
    Vec3 place = camera.place;
    if (i < 3) {
      set_axes(moved, turn_about(by) * camera_axes(moved));
    } else {
      place += by;
    }
    Vec2 there;
    ASSERT_TRUE(project(moved, point - place, there));
    const Vec2 slope = (there - here) / kStep;
    EXPECT_NEAR(slope.x, slopes[static_cast<std::size_t>(i)].x, 1e-2) << i;
    EXPECT_NEAR(slope.y, slopes[static_cast<std::size_t>(i)].y, 1e-2) << i;
  }
}

// Cameras a little off, boards a little off: the fit must find the truth, whose sightings it was given.
TEST(Adjustment, FindsTheTruthFromExactCorners) {
  const Board board;
  const std::vector<SimulatedCamera> truth = simulated_cameras(kSize);
  const std::vector<SimulatedShot> shots = simulated_shots(truth, board, 6, 4);
  const std::vector<Sighting> sightings = noisy_sightings(truth, shots, board, 0.0);
  std::vector<AdjustedCamera> cameras;
  for (const SimulatedCamera& camera : truth) {
    AdjustedCamera& start = cameras.emplace_back();
    start.view = camera.view;
    start.place = camera.place;
    start.held = cameras.size() == 1;
    if (start.held) continue;
    set_axes(start.view, turn_about({0.01, -0.01, 0.02}) * camera_axes(start.view));
    start.place += Vec3{0.01, 0.0, -0.01};
    start.view.focal *= 1.01;
  }
  std::vector<Pose> boards;
  for (const SimulatedShot& shot : shots) {
    boards.push_back(shot.board);
    boards.back().place += Vec3{0.005, 0.0, 0.005};
  }
  Adjustment adjustment(cameras, boards, sightings, board);
  ASSERT_TRUE(adjustment.fit());
  for (std::size_t c = 0; c < truth.size(); ++c) {
    const AdjustedCamera& found = adjustment.cameras()[c];
    EXPECT_LT(angle_between(camera_axes(found.view), camera_axes(truth[c].view)), 1e-6) << c;
    EXPECT_LT(glm::length(found.place - truth[c].place), 1e-6) << c;
    EXPECT_NEAR(found.view.focal.x / truth[c].view.focal.x, 1.0, 1e-6) << c;
  }
}

// The covariance says what noise does: over many corners the errors found are within a few deviations of it.
TEST(Adjustment, KnowsHowWellItKnows) {
  const Board board;
  const std::vector<SimulatedCamera> truth = simulated_cameras(kSize);
  const std::vector<SimulatedShot> shots = simulated_shots(truth, board, 12, 5);
  const std::vector<Sighting> sightings = noisy_sightings(truth, shots, board, 0.2);
  std::vector<AdjustedCamera> cameras;
  for (const SimulatedCamera& camera : truth)
    cameras.push_back({camera.view, camera.place, cameras.empty(), 5});
  std::vector<Pose> boards;
  for (const SimulatedShot& shot : shots) boards.push_back(shot.board);
  Adjustment adjustment(cameras, boards, sightings, board);
  ASSERT_TRUE(adjustment.fit());
  EXPECT_NEAR(adjustment.sigma(), 0.2, 0.01);
  double sum = 0.0;
  int count = 0;
  for (std::size_t c = 1; c < truth.size(); ++c) {
    const Adjustment::Block spread = adjustment.covariance(c, c);
    const AdjustedCamera& found = adjustment.cameras()[c];
    for (int axis = 0; axis < 3; ++axis) {
      const double deviation =
          std::sqrt(spread[static_cast<std::size_t>(3 + axis)][static_cast<std::size_t>(3 + axis)]);
      const double off = (found.place - truth[c].place)[axis] / deviation;
      sum += off * off;
      ++count;
    }
    const double focal = (found.view.focal.x - truth[c].view.focal.x) / std::sqrt(spread[6][6]);
    sum += focal * focal;
    ++count;
  }
  // Twelve squares of what should be standard normal.
  EXPECT_GT(sum / count, 0.2);
  EXPECT_LT(sum / count, 3.0);
}

}  // namespace
}  // namespace cupola
