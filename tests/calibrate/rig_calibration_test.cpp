// Calibration of simulated rigs: what comes out against what they are.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/rig_calibration.h"

#include <gmock/gmock.h>

#include <cmath>

#include "pipeline/calibrate/opencv.h"
#include "tests/calibrate/simulated_rig.h"

namespace cupola {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr Size kSize{600, 600};

class RigCalibrationTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!have_opencv()) GTEST_SKIP() << "built without OpenCV";
  }
  RigCalibration calibrate(const std::vector<Sighting>& sightings,
                           std::optional<Distortion> model = Distortion::kRadialTangential, int threads = 2) {
    WorkerPool pool(threads);
    Rig rig;
    rig.views = nominal_views(kSize);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < shots_.size(); ++i) names.push_back(std::to_string(i));
    return calibrate_rig(rig, board_, sightings, names, std::vector<Size>(4, kSize), model, pool);
  }
  // Radians between where a far point is and where the calibration takes it to be, over the picture.
  double worst_direction(const View& found, const View& truth) const {
    double worst = 0.0;
    for (int y = 20; y < kSize.height; y += 40) {
      for (int x = 20; x < kSize.width; x += 40) {
        const Vec2 at(x, y);
        worst = std::max(worst, glm::length(direction_at(found, at) - direction_at(truth, at)));
      }
    }
    return worst;
  }
  Board board_;
  std::vector<SimulatedCamera> truth_ = simulated_cameras(kSize);
  std::vector<SimulatedShot> shots_ = simulated_shots(truth_, board_, 12, 4);
};

// A texel in the middle is 0.33 degrees.
TEST_F(RigCalibrationTest, FindsLensesAndPosesFromCornersATwentiethOfATexelOff) {
  const RigCalibration found = calibrate(noisy_sightings(truth_, shots_, board_, 0.05));
  EXPECT_THAT(found.troubles, IsEmpty());
  EXPECT_THAT(found.left_out, IsEmpty());
  EXPECT_EQ(found.seams.size(), 5U) << "left and right do not meet";
  Vec3 middle{0.0};
  for (const SimulatedCamera& camera : truth_) middle += camera.place / 4.0;
  for (std::size_t c = 0; c < 4; ++c) {
    const CameraCalibration& camera = found.cameras[c];
    const SimulatedCamera& truth = truth_[c];
    EXPECT_TRUE(camera.has_lens && camera.joined);
    EXPECT_NEAR(camera.rms, 0.05 * std::sqrt(2.0), 0.005);
    EXPECT_NEAR(camera.view.focal.x / truth.view.focal.x, 1.0, 0.001) << c;
    EXPECT_LT(angle_between(camera_axes(camera.view), camera_axes(truth.view)), 0.001) << c;
    EXPECT_LT(glm::length(camera.position_m - (truth.place - middle)), 0.001) << c;
    EXPECT_LT(worst_direction(camera.view, truth.view), 0.0015) << c << ": a quarter of a texel";
    EXPECT_LT(camera.focal_deviation, 0.001);
    EXPECT_LT(camera.turn_deviation_deg, 0.05);
  }
  for (const SeamCalibration& seam : found.seams) {
    EXPECT_GT(seam.rms, 0.02);
    EXPECT_LT(seam.rms, 0.4);
    EXPECT_GE(seam.worst, seam.rms);
  }
}

// What the covariance says of seams is what they come out as: the same far point in both views.
TEST_F(RigCalibrationTest, ExpectsTheSeamErrorsThatThereAre) {
  const RigCalibration found = calibrate(noisy_sightings(truth_, shots_, board_, 0.1));
  double expected = 0.0;
  double measured = 0.0;
  for (const SeamCalibration& seam : found.seams) {
    const auto a = static_cast<std::size_t>(seam.a);
    const auto b = static_cast<std::size_t>(seam.b);
    double squares = 0.0;
    int count = 0;
    const Vec3 middle = glm::normalize(truth_[a].view.forward + truth_[b].view.forward);
    const Vec3 along = glm::cross(truth_[a].view.forward, truth_[b].view.forward);
    for (double t = -0.8; t <= 0.8; t += 0.02) {
      const Vec3 d = glm::normalize(middle + t * along);
      Vec2 in_a;
      Vec2 in_b;
      Vec2 out;
      if (!covers(truth_[a].view, d) || !covers(truth_[b].view, d)) continue;
      project(truth_[a].view, d, in_a);
      project(truth_[b].view, d, in_b);
      if (!project(found.cameras[b].view, direction_at(found.cameras[a].view, in_a), out)) continue;
      squares += glm::dot(out - in_b, out - in_b);
      ++count;
    }
    expected += seam.rms * seam.rms;
    measured += squares / count;
  }
  EXPECT_GT(measured, 0.15 * expected);
  EXPECT_LT(measured, 4.0 * expected);
}

TEST_F(RigCalibrationTest, IsTheSameForAnyNumberOfThreads) {
  const std::vector<Sighting> sightings = noisy_sightings(truth_, shots_, board_, 0.05);
  const RigCalibration one = calibrate(sightings, Distortion::kRadialTangential, 1);
  const RigCalibration three = calibrate(sightings, Distortion::kRadialTangential, 3);
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_EQ(one.cameras[c].view.forward, three.cameras[c].view.forward);
    EXPECT_EQ(one.cameras[c].view.coefficients, three.cameras[c].view.coefficients);
  }
}

TEST_F(RigCalibrationTest, LeavesAShotOutWhoseBoardMovedBetweenTheCameras) {
  std::vector<Sighting> sightings = noisy_sightings(truth_, shots_, board_, 0.05);
  const int moved = static_cast<int>(shots_.size()) - 2;
  Pose pose = shots_[static_cast<std::size_t>(moved)].board;
  pose.place += Vec3{0.01, 0.01, 0.01};
  const int second = shots_[static_cast<std::size_t>(moved)].cameras[1];
  const std::optional<Sighting> later =
      exact_sighting(truth_[static_cast<std::size_t>(second)], board_, pose);
  ASSERT_TRUE(later);
  for (Sighting& sighting : sightings) {
    if (sighting.shot == moved && sighting.camera == second) sighting.corners = later->corners;
  }
  const RigCalibration found = calibrate(sightings);
  ASSERT_EQ(found.left_out.size(), 1U);
  EXPECT_EQ(found.left_out[0].shot, moved);
  EXPECT_GT(found.left_out[0].rms, 0.4);
  for (std::size_t c = 0; c < 4; ++c)
    EXPECT_LT(angle_between(camera_axes(found.cameras[c].view), camera_axes(truth_[c].view)), 0.001) << c;
}

TEST_F(RigCalibrationTest, SaysWhichCameraIsJoinedToNoneAndKeepsItsPose) {
  std::vector<Sighting> sightings = noisy_sightings(truth_, shots_, board_, 0.05);
  std::erase_if(sightings, [&](const Sighting& sighting) {  // right alone
    return sighting.camera == 2 && shots_[static_cast<std::size_t>(sighting.shot)].cameras.size() > 1;
  });
  const RigCalibration found = calibrate(sightings);
  EXPECT_THAT(
      found.troubles,
      testing::Contains(HasSubstr("camera right: no shot shows the whole board to it and to another")));
  EXPECT_FALSE(found.cameras[2].joined);
  EXPECT_TRUE(found.cameras[2].has_lens);
  EXPECT_LT(angle_between(camera_axes(found.cameras[2].view), camera_axes(nominal_views(kSize)[2])), 1e-9);
  EXPECT_TRUE(found.cameras[3].joined);
}

TEST_F(RigCalibrationTest, SaysWhatIsMissing) {
  std::vector<Sighting> sightings = noisy_sightings(truth_, shots_, board_, 0.05);
  int kept = 0;
  std::erase_if(sightings, [&](const Sighting& sighting) {
    if (sighting.camera == 1) return ++kept > 3;  // three shots of left
    if (sighting.camera != 3) return false;
    return std::any_of(sighting.corners.begin(), sighting.corners.end(),
                       [](const Vec2& at) { return at.x < kSize.width / 3.0; });
  });
  const RigCalibration found = calibrate(sightings);
  EXPECT_THAT(found.troubles, testing::Contains(HasSubstr("camera left: 3 shots show the whole board")));
  EXPECT_THAT(found.troubles,
              testing::Contains(HasSubstr("camera top: no board in the left third of the picture")));
  EXPECT_FALSE(found.cameras[1].has_lens);
}

// Corners that no lens makes: every second one a texel and more to the side.
TEST_F(RigCalibrationTest, SaysThatItIsPoorWhereCornersAreWorseThanATexel) {
  const RigCalibration found = calibrate(noisy_sightings(truth_, shots_, board_, 1.5));
  EXPECT_THAT(found.troubles, testing::Contains(HasSubstr("expected 1 at most: is the board flat")));
  EXPECT_THAT(found.troubles, testing::Contains(HasSubstr("take more shots that both see")));
}

TEST_F(RigCalibrationTest, TakesTheFisheyeModelForAFisheye) {
  for (SimulatedCamera& camera : truth_) {
    camera.view.distortion = Distortion::kFisheye;
    camera.view.coefficients = {0.01, -0.004, 0.0, 0.0};
    camera.view.limit = 3.0;
    camera.view.focal = Vec2{0.5 / 1.1};  // 126 degrees
  }
  shots_ = simulated_shots(truth_, board_, 10, 3);
  const RigCalibration found = calibrate(noisy_sightings(truth_, shots_, board_, 0.05), std::nullopt);
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_EQ(found.cameras[c].view.distortion, Distortion::kFisheye) << c;
    EXPECT_NEAR(found.cameras[c].view.focal.x / truth_[c].view.focal.x, 1.0, 0.002) << c;
  }
}

}  // namespace
}  // namespace cupola
