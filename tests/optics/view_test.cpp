// Views: the cube of CONVENTIONS, gradients, ownership, seams without gaps, calibrated cameras.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "pipeline/optics/calibration.h"
#include "pipeline/optics/seam.h"

namespace cupola {
namespace {

View face(const char* name, Size size = {1024, 960}) {
  View view;
  view.name = name;
  EXPECT_TRUE(named_pose(name, view));
  view.size = size;
  return view;
}

View radial_tangential() {
  View view = face("front", {1280, 720});
  view.focal = {0.8, 0.8 * 16 / 9};
  view.principal = {0.51, 0.49};
  view.distortion = Distortion::kRadialTangential;
  view.coefficients = {-0.2, 0.05, 0.001, -0.002, -0.004};
  EXPECT_EQ(limit_distortion(view), "");
  return view;
}

View fisheye() {
  View view = face("front", {1000, 1000});
  view.focal = {0.29, 0.29};
  view.distortion = Distortion::kFisheye;
  view.coefficients = {-0.01, 0.002, -0.0003, 0.00001};
  EXPECT_EQ(limit_distortion(view), "");
  return view;
}

Vec3 random_direction(std::mt19937_64& random) {
  std::normal_distribution<> normal;
  return glm::normalize(Vec3{normal(random), normal(random), normal(random)});
}

TEST(View, CubeFacesAreThoseOfTheConventions) {
  const View front = face("front");
  const View left = face("left");
  Vec2 uv;
  ASSERT_TRUE(project(front, {0.5, 0.25, -1}, uv));
  EXPECT_DOUBLE_EQ(uv.x, (0.5 + 1) * 512);
  EXPECT_DOUBLE_EQ(uv.y, (1 - 0.25) * 480);
  ASSERT_TRUE(project(left, {-1, 0, -0.5}, uv));
  EXPECT_DOUBLE_EQ(uv.x, 1.5 * 512) << "the left face's right half is next to the front";
  for (const char* name : {"front", "left", "right", "top", "bottom", "back"}) {
    const View view = face(name);
    EXPECT_LT(glm::length(glm::cross(view.right, view.up) + view.forward), 1e-15)
        << name << " is right-handed";
  }
  View ignored;
  EXPECT_FALSE(named_pose("frnt", ignored));
}

// Any, from up to half the distance at which seams close: the farthest that there may be.
Vec3 random_shift(std::mt19937_64& random) {
  return random_direction(random) * std::uniform_real_distribution<>(0.0, 0.5)(random);
}

// Three models, in the rig's centre and beside it.
class EveryView : public testing::TestWithParam<int> {
 protected:
  View view() const {
    View view = GetParam() % 3 == 0 ? face("top") : GetParam() % 3 == 1 ? radial_tangential() : fisheye();
    if (GetParam() >= 3) view.shift = {0.2, -0.15, 0.1};
    return view;
  }
};

TEST_P(EveryView, DirectionAtIsTheInverseOfProject) {
  const View view = this->view();
  std::mt19937_64 random(2);
  for (int i = 0; i < 20000; ++i) {
    const Vec2 at{std::uniform_real_distribution<>(0, view.size.width)(random),
                  std::uniform_real_distribution<>(0, view.size.height)(random)};
    const Vec3 d = direction_at(view, at);
    ASSERT_NEAR(glm::length(d), 1.0, 1e-14);
    Vec2 back;
    ASSERT_TRUE(project(view, d * 3.0, back));
    ASSERT_LT(glm::length(back - at), 1e-9) << at.x << ' ' << at.y;
  }
}

TEST_P(EveryView, GradientsAreExactAndDensityIsTexelsASteradian) {
  const View view = this->view();
  std::mt19937_64 random(3);
  for (int i = 0; i < 5000; ++i) {
    const Vec2 at{std::uniform_real_distribution<>(0, view.size.width)(random),
                  std::uniform_real_distribution<>(0, view.size.height)(random)};
    const Vec3 d = direction_at(view, at);
    ViewSample sample;
    ASSERT_TRUE(project(view, d, sample));
    ASSERT_LT(glm::length(sample.uv - at), 1e-9);
    constexpr double kStep = 1e-6;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 step{};
      step[axis] = kStep;
      Vec2 low;
      Vec2 high;
      ASSERT_TRUE(project(view, d - step, low) && project(view, d + step, high));
      const Vec2 difference = (high - low) / (2 * kStep);
      ASSERT_NEAR(sample.du[axis], difference.x, 1e-4 * glm::length(sample.du));
      ASSERT_NEAR(sample.dv[axis], difference.y, 1e-4 * glm::length(sample.dv));
    }
    // A texel's solid angle from its edges' directions.
    const Vec3 a = direction_at(view, at + Vec2{1e-3, 0}) - direction_at(view, at - Vec2{1e-3, 0});
    const Vec3 b = direction_at(view, at + Vec2{0, 1e-3}) - direction_at(view, at - Vec2{0, 1e-3});
    ASSERT_NEAR(density(sample, d) * glm::length(glm::cross(a, b)) / 4e-6, 1.0, 1e-4);
  }
}

INSTANTIATE_TEST_SUITE_P(Models, EveryView, testing::Range(0, 6));

// The sphere of radius 3 m about the centre, met the long way: the point, then the eye's direction to it.
TEST_P(EveryView, SeesFromBesideTheCentreWhatIsOnTheSphereThere) {
  View view = this->view();
  View eye = view;
  eye.shift = Vec3{0.0};
  std::mt19937_64 random(7);
  for (int i = 0; i < 20000; ++i) {
    view.position_m = 3.0 * random_shift(random);
    ASSERT_TRUE(set_shifts({&view, 1}, 3.0));
    const Vec3 d = random_direction(random);
    Vec2 there;
    Vec2 expected;
    const bool seen = project(eye, 3.0 * d - view.position_m, expected);
    ASSERT_EQ(project(view, d, there), seen);
    if (seen) {
      ASSERT_LT(glm::length(there - expected), 1e-9 * (1.0 + glm::length(expected)));
    }
    const Vec2 at{std::uniform_real_distribution<>(0, view.size.width)(random),
                  std::uniform_real_distribution<>(0, view.size.height)(random)};
    const Vec3 point = direction_at(view, at) * 3.0 - view.position_m;
    ASSERT_LT(glm::length(glm::normalize(point) - direction_at(eye, at)), 1e-12);
  }
}

TEST(View, IsAsItWasWhereItsEyeIsInTheCentre) {
  View view = face("front");
  View moved = view;
  moved.position_m = {0.3, 0.2, 0.1};
  ASSERT_TRUE(set_shifts({&moved, 1}, HUGE_VAL));
  EXPECT_FALSE(is_shifted(moved)) << "seams that close at infinity have no parallax to undo";
  EXPECT_FALSE(set_shifts({&moved, 1}, 0.7)) << "less than twice as far as the eye";
  EXPECT_FALSE(is_shifted(moved));
}

TEST(View, FisheyeReachesPast90DegreesWhereAnArctangentOfTheSlopeFails) {
  const View view = fisheye();
  ViewSample sample;
  const double angle = 95 * std::numbers::pi / 180;
  ASSERT_TRUE(project(view, {std::sin(angle), 0, -std::cos(angle)}, sample));
  EXPECT_GT(sample.uv.x, 500 + 290 * 1.55);
  ASSERT_TRUE(project(view, {1, 0, 0}, sample));
  EXPECT_TRUE(std::isfinite(sample.uv.x) && std::isfinite(glm::length(sample.du)));
}

TEST(View, SixFacesOwnEveryDirectionAndTheNearestAxisWins) {
  std::vector<View> views;
  for (const char* name : {"front", "left", "right", "top", "bottom", "back"}) views.push_back(face(name));
  std::mt19937_64 random(4);
  for (int i = 0; i < 200000; ++i) {
    const Vec3 d = random_direction(random);
    const int own = owner(views, d);
    ASSERT_GE(own, 0);
    for (const View& other : views) ASSERT_LE(glm::dot(d, other.forward), glm::dot(d, views[own].forward));
  }
  EXPECT_EQ(owner(views, {1, 0, -1}), 0) << "a tie goes to the earlier view";
  EXPECT_EQ(owner(views, {-1, 1, 0}), 1);
  EXPECT_EQ(owner(views, {1, 1, 1}), 2);
}

TEST(View, DirectionsThatNoViewCoversHaveNoOwner) {
  const std::vector<View> views = {face("front"), face("top")};
  EXPECT_EQ(owner(views, {0, -1, 0}), -1);
  EXPECT_EQ(owner(views, {0, 0, 1}), -1);
}

TEST(View, TexelsNearADirectionAreAllFound) {
  std::mt19937_64 random(5);
  int found = 0;
  for (int i = 0; i < 300; ++i) {
    View view = face("left", {64, 48});
    view.focal = {std::uniform_real_distribution<>(0.05, 3)(random), 0.4};
    if (i % 2 == 1) view.shift = random_shift(random);
    const Vec3 axis = random_direction(random);
    const double angle = std::uniform_real_distribution<>(0.0, 1.5)(random);
    const TexelBox box = texels_near(view, axis, angle);
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) {
        if (glm::dot(direction_at(view, {x + 0.5, y + 0.5}), axis) < std::cos(angle)) continue;
        ++found;
        ASSERT_TRUE(x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1) << x << ' ' << y << ' ' << angle;
      }
    }
  }
  EXPECT_GT(found, 1000);
}

TEST(View, TexelsNearADirectionAreAllFoundInDistortedViewsToo) {
  std::mt19937_64 random(6);
  int found = 0;
  for (int i = 0; i < 300; ++i) {
    View view = i % 2 == 0 ? radial_tangential() : fisheye();
    view.size = {80, 60};
    if (i % 4 > 1) view.shift = random_shift(random);
    const Vec3 axis = direction_at(view, {std::uniform_real_distribution<>(-5, 85)(random), 30.0});
    const double angle = std::uniform_real_distribution<>(0.0, i % 3 == 0 ? 0.6 : 0.1)(random);
    const TexelBox box = texels_near(view, axis, angle);
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 80; ++x) {
        if (glm::dot(direction_at(view, {x + 0.5, y + 0.5}), axis) < std::cos(angle)) continue;
        ++found;
        ASSERT_TRUE(x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1) << x << ' ' << y << ' ' << angle;
      }
    }
  }
  EXPECT_GT(found, 1000);
}

TEST(View, TexelsNearADirectionAreFewWhenTheAngleIsSmall) {
  const View view = face("front", {1024, 1024});
  const TexelBox box = texels_near(view, {0, 0, -1}, 0.01);
  EXPECT_LE(box.x1 - box.x0, 13);
  EXPECT_TRUE(texels_near(view, {0, 0, 1}, 0.5).empty());
  EXPECT_TRUE(texels_near(view, {1, 0, 0}, 0.5).empty());
}

}  // namespace
}  // namespace cupola
