// Frame models: published landmarks, unit rays, exact derivatives, crops.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/frame_geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace cupola {
namespace {

FrameGeometry fisheye(Lens lens) {
  FrameGeometry frame;
  frame.size = {1966, 1436};
  frame.center = {983, 983};
  frame.radius = 983;
  frame.lens = std::move(lens);
  return frame;
}

FrameGeometry world_map(FrameModel model) {
  FrameGeometry frame;
  frame.model = model;
  frame.size = {1024, 512};
  frame.fov = 2 * std::numbers::pi;
  return frame;
}

FrameGeometry chrome_ball() {
  FrameGeometry frame;
  frame.model = FrameModel::kChromeBall;
  frame.size = {400, 400};
  frame.center = {200, 200};
  frame.radius = 200;
  return frame;
}

FrameGeometry cube() {
  FrameGeometry frame;
  frame.model = FrameModel::kCube;
  frame.size = {300, 200};
  frame.columns = 3;
  for (const char* name : {"front", "left", "right", "top", "bottom", "back"}) {
    View face;
    named_pose(name, face);
    face.size = {100, 100};
    frame.faces.push_back(face);
  }
  return frame;
}

struct NamedFrame {
  const char* name;
  FrameGeometry frame;
};

class EveryFrame : public testing::TestWithParam<NamedFrame> {};

TEST_P(EveryFrame, RaysAreUnitAndDerivativesExact) {
  const FrameGeometry& frame = GetParam().frame;
  std::mt19937_64 random(1);
  int inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec2 p{std::uniform_real_distribution<>(0, frame.size.width)(random),
                 std::uniform_real_distribution<>(0, frame.size.height)(random)};
    DirectionAndSlope at;
    DirectionAndSlope low;
    DirectionAndSlope high;
    if (!ray(frame, p, at)) continue;
    ++inside;
    ASSERT_NEAR(glm::length(at.direction), 1.0, 1e-14);
    constexpr double kStep = 1e-4;
    for (const bool across : {true, false}) {
      const Vec2 step = across ? Vec2{kStep, 0} : Vec2{0, kStep};
      if (!ray(frame, p - step, low) || !ray(frame, p + step, high)) continue;
      const Vec3 difference = (high.direction - low.direction) / (2 * kStep);
      const Vec3 analytic = across ? at.d_da : at.d_db;
      if (glm::length(difference) > 1.0) continue;  // the two sides of a seam of an atlas
      // Second-order differences err by the third derivative, which grows without bound at a limb.
      ASSERT_LT(glm::length(difference - analytic), 2e-7 + 1e-4 * glm::length(analytic)) << p.x << ' ' << p.y;
    }
  }
  EXPECT_GT(inside, 10000);
}

INSTANTIATE_TEST_SUITE_P(
    Models, EveryFrame,
    testing::Values(NamedFrame{"omnimax", fisheye(omnimax_c430())},
                    NamedFrame{"equidistant", fisheye(equidistant(180))},
                    NamedFrame{"equidistant300", fisheye(equidistant(300))},
                    NamedFrame{"equisolid", fisheye({LensModel::kEquisolid, 1.5, {}, ""})},
                    NamedFrame{"stereographic", fisheye({LensModel::kStereographic, 1.5, {}, ""})},
                    NamedFrame{"orthographic", fisheye({LensModel::kOrthographic, 1.5, {}, ""})},
                    NamedFrame{"opencv", fisheye({LensModel::kOpencvFisheye, 1.6, {-0.02, 0.003}, ""})},
                    NamedFrame{"equirectangular", world_map(FrameModel::kEquirectangular)},
                    NamedFrame{"cylindrical", world_map(FrameModel::kCylindrical)},
                    NamedFrame{"mercator", world_map(FrameModel::kMercator)},
                    NamedFrame{"chrome_ball", chrome_ball()}, NamedFrame{"cube", cube()}),
    [](const auto& instance) { return instance.param.name; });

Vec3 direction(const FrameGeometry& frame, double x, double y) {
  DirectionAndSlope at;
  EXPECT_TRUE(ray(frame, {x, y}, at)) << x << ' ' << y;
  return at.direction;
}

void expect_near(const Vec3& a, const Vec3& b, double bound = 1e-12) {
  EXPECT_LT(glm::length(a - b), bound);
}

TEST(FrameGeometry, FisheyeCentreLooksAlongTheAxisAndTheRightEdgeRight) {
  const FrameGeometry frame = fisheye(equidistant(180));
  expect_near(direction(frame, 983, 983), {0, 0, -1});
  expect_near(direction(frame, 1966, 983), {1, 0, 0});
  expect_near(direction(frame, 983, 0), {0, 1, 0});
}

TEST(FrameGeometry, SlopeIsContinuousThroughTheCentre) {
  const FrameGeometry frame = fisheye(omnimax_c430());
  DirectionAndSlope at;
  DirectionAndSlope beside;
  ASSERT_TRUE(ray(frame, {983, 983}, at));
  for (const double offset : {1e-9, 1e-6, 1e-4}) {
    ASSERT_TRUE(ray(frame, {983 + offset, 983 - offset}, beside));
    EXPECT_LT(glm::length(at.d_da - beside.d_da), 1e-8);
  }
  expect_near(at.d_da, {1.411269 / 983, 0, 0});
  expect_near(at.d_db, {0, -1.411269 / 983, 0});
}

TEST(FrameGeometry, OutsideTheCircleIsOutsideTheImage) {
  const FrameGeometry frame = fisheye(omnimax_c430());
  DirectionAndSlope ignored;
  EXPECT_FALSE(ray(frame, {0.5, 0.5}, ignored));
  EXPECT_TRUE(ray(frame, {0.5, 983}, ignored));
}

TEST(FrameGeometry, OmnimaxCropKeepsWhatLiesAboveThePlane45DegreesUnderTheAxis) {
  FrameGeometry frame = fisheye(omnimax_c430());
  frame.crop = Crop::kOmnimax;
  frame.size = {1966, 1966};
  const double edge = 983 + 983 * radius_at(frame.lens, std::numbers::pi / 4);  // straight below the centre
  DirectionAndSlope ignored;
  EXPECT_TRUE(ray(frame, {983, edge - 0.01}, ignored));
  EXPECT_FALSE(ray(frame, {983, edge + 0.01}, ignored));
  EXPECT_NEAR(1966 / edge, 1.283458, 1e-6) << "the whole field is W x W / 1.283458";
  EXPECT_TRUE(ray(frame, {1900, 983}, ignored));
}

TEST(FrameGeometry, WorldMapsHaveFrontInTheMiddleAndRightToTheRight) {
  for (const FrameModel model :
       {FrameModel::kEquirectangular, FrameModel::kCylindrical, FrameModel::kMercator}) {
    const FrameGeometry frame = world_map(model);
    expect_near(direction(frame, 512, 256), {0, 0, -1});
    expect_near(direction(frame, 768, 256), {1, 0, 0});
    EXPECT_GT(direction(frame, 512, 100).y, 0.5);
  }
  expect_near(direction(world_map(FrameModel::kEquirectangular), 512, 0), {0, 1, 0});
}

TEST(FrameGeometry, ChromeBallShowsTheEyeInItsMiddleAndThePlaceBehindItAtItsLimb) {
  const FrameGeometry frame = chrome_ball();
  expect_near(direction(frame, 200, 200), {0, 0, 1});
  expect_near(direction(frame, 200 + 200 * std::sqrt(0.5), 200), {1, 0, 0});
  expect_near(direction(frame, 200, 200 - 200 * std::sqrt(0.5)), {0, 1, 0});
  expect_near(direction(frame, 399.99999, 200), {0, 0, -1}, 1e-3);
}

TEST(FrameGeometry, CubeAtlasLooksThroughEachFacesMiddle) {
  const FrameGeometry frame = cube();
  expect_near(direction(frame, 50, 50), {0, 0, -1});
  expect_near(direction(frame, 150, 50), {-1, 0, 0});
  expect_near(direction(frame, 250, 150), {0, 0, 1});
}

}  // namespace
}  // namespace cupola
