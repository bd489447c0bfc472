// Shares of views: whole, symmetrical, without steps, and nothing where no two pictures overlap.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/seam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace cupola {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

View camera(const char* pose, double fov_deg) {
  View view;
  view.name = pose;
  named_pose(pose, view);
  view.size = {400, 300};
  view.focal.x = 0.5 / std::tan(fov_deg / 2.0 * kDegree);
  view.focal.y = view.focal.x * 4.0 / 3.0;
  return view;
}

std::vector<View> five(double fov_deg) {
  return {camera("front", fov_deg), camera("left", fov_deg), camera("right", fov_deg), camera("top", fov_deg),
          camera("bottom", fov_deg)};
}

std::array<double, 6> shares_at(const std::vector<View>& views, double feather_deg, const Vec3& d) {
  std::array<double, 6> shares{};
  if (Feather({feather_deg}).shares(views, d, shares)) return shares;
  shares = {};
  const int home = owner(views, d);
  if (home >= 0) shares[static_cast<std::size_t>(home)] = 1.0;
  return shares;
}

Vec3 any_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(Vec3{normal(random), normal(random), normal(random)});
}

TEST(Seams, SharesAreWholeAndOfViewsThatCoverTheRay) {
  std::mt19937 random(1);
  const std::vector<View> views = five(125.0);
  int mixed = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 d = any_direction(random);
    const auto shares = shares_at(views, 8.0, d);
    double sum = 0.0;
    for (std::size_t v = 0; v < views.size(); ++v) {
      EXPECT_GE(shares[v], 0.0);
      EXPECT_TRUE(shares[v] == 0.0 || covers(views[v], d));
      sum += shares[v];
      mixed += shares[v] > 0.0 && shares[v] < 1.0 ? 1 : 0;
    }
    EXPECT_NEAR(sum, owner(views, d) < 0 ? 0.0 : 1.0, 1e-12);
  }
  EXPECT_GT(mixed, 1000);
}

TEST(Seams, AreHalfAndHalfInTheMiddleAndNothingAtTheBandsEdge) {
  const std::vector<View> views = five(125.0);
  const auto left_at = [&](double deg) {  // from the front's axis, level
    return shares_at(views, 10.0, {-std::sin(deg * kDegree), 0.0, -std::cos(deg * kDegree)})[1];
  };
  EXPECT_NEAR(left_at(45.0), 0.5, 1e-12);
  EXPECT_EQ(left_at(39.9), 0.0);
  EXPECT_EQ(left_at(50.1), 1.0);
  for (double deg = 40.0; deg <= 45.0; deg += 0.25)
    EXPECT_NEAR(left_at(deg) + left_at(90.0 - deg), 1.0, 1e-12);
}

// Whether the best picture goes on for a dozen texels around the ray. Where two pictures end in one point
// their shares change as fast as one likes.
bool well_inside(const std::vector<View>& views, const Vec3& d) {
  const int home = owner(views, d);
  Vec2 uv;
  if (home < 0 || !project(views[static_cast<std::size_t>(home)], d, uv)) return false;
  return uv.x > 12.0 && uv.x < 388.0 && uv.y > 12.0 && uv.y < 288.0;
}

// Along great circles in steps of a hundredth of a degree: over a band of 8 degrees, of which the edge of a
// picture may take half, no share changes faster than its ramps do.
TEST(Seams, HaveNoStepsWherePicturesOverlap) {
  std::mt19937 random(2);
  const std::vector<View> views = five(125.0);
  int compared = 0;
  for (int circle = 0; circle < 50; ++circle) {
    const Vec3 a = any_direction(random);
    const Vec3 b = glm::normalize(glm::cross(a, any_direction(random)));
    std::array<double, 6> before{};
    bool inside_before = false;
    for (int i = 0; i < 36000; ++i) {
      const double angle = i * 0.01 * kDegree;
      const Vec3 d = std::cos(angle) * a + std::sin(angle) * b;
      const auto now = shares_at(views, 8.0, d);
      const bool inside = well_inside(views, d);
      for (std::size_t v = 0; inside && inside_before && v < views.size(); ++v, ++compared)
        ASSERT_LT(std::abs(now[v] - before[v]), 0.01) << angle / kDegree;
      before = now;
      inside_before = inside;
    }
  }
  EXPECT_GT(compared, 100000);
}

TEST(Seams, FacesThatOnlyMeetAreNotMixed) {
  std::mt19937 random(3);
  std::vector<View> views = five(90.0);
  for (View& view : views) view.size = {300, 300};
  for (View& view : views) view.focal = {0.5, 0.5};
  for (int i = 0; i < 20000; ++i) {
    std::array<double, 6> shares{};
    EXPECT_FALSE(Feather({20.0}).shares(views, any_direction(random), shares));
  }
}

}  // namespace
}  // namespace cupola
