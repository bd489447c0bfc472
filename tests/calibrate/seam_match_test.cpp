// Seams of simulated cameras with known errors: what is measured is what there is, and else nothing.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/seam_match.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "pipeline/calibrate/pose.h"
#include "tests/calibrate/simulated_rig.h"

namespace cupola {
namespace {

constexpr Size kSize{320, 320};
constexpr std::size_t kFront = 0;
constexpr std::size_t kLeft = 1;
using Brightness = std::function<double(const Vec3&)>;  // 0 to 255 by direction

// Waves of many directions and lengths, the shortest some seven texels long.
double waves(const Vec3& d) {
  static const std::vector<Vec3> fronts = [] {
    SimulatedNoise noise(5);
    std::vector<Vec3> made;
    for (int i = 0; i < 20; ++i) {
      const Vec3 along = glm::normalize(Vec3{noise.next(), noise.next(), noise.next()});
      made.push_back((15.0 + 6.0 * i) * along);
    }
    return made;
  }();
  double sum = 0.0;
  for (std::size_t i = 0; i < fronts.size(); ++i)
    sum += std::cos(glm::dot(fronts[i], d) + static_cast<double>(i * i));
  return 120.0 + 17.0 * sum;
}

// The lenses and poses of the simulated cameras, here as the rig has them.
Rig rig_of_cameras() {
  Rig rig;
  rig.frame.size = {512, 512};
  rig.frame.center = {256.0, 256.0};
  rig.frame.radius = 256.0;
  rig.frame.lens = equidistant(180.0);
  for (const SimulatedCamera& camera : simulated_cameras(kSize)) rig.views.push_back(camera.view);
  return rig;
}

GreyPicture taken(const View& view, const Brightness& world) {
  const ImageBuffer rgb = Photographer({view, {}}).take([&](const Vec3& d) { return Vec3{world(d)}; });
  GreyPicture picture{view.size, {}};
  for (int y = 0; y < view.size.height; ++y) {
    const auto* row = rgb.pixels().samples<std::uint8_t>(0, y);
    for (int x = 0; x < view.size.width; ++x) picture.texels.push_back(row[3 * x]);
  }
  return picture;
}

GreyPicture noisy(GreyPicture picture, double steps, std::uint32_t seed) {
  SimulatedNoise noise(seed);
  for (std::uint8_t& texel : picture.texels)
    texel = static_cast<std::uint8_t>(std::clamp(std::lround(texel + steps * noise.next()), 0L, 255L));
  return picture;
}

// A camera that is turned about its up and its forward axis, so far that a thing in the middle of the seam
// with the front is by so many texels elsewhere in its picture.
View turned(const View& nominal, double texels) {
  const Vec3 seam = glm::normalize(Vec3{-1.0, 0.0, -1.0});
  const auto by = [&](double angle) {
    View view = nominal;
    set_axes(view, turn_about(angle * view.up) * turn_about(0.5 * angle * view.forward) * camera_axes(view));
    return view;
  };
  const auto moved = [&](double angle) {
    Vec2 before;
    Vec2 after;
    project(nominal, seam, before);
    project(by(angle), seam, after);
    return glm::length(after - before);
  };
  double angle = 0.0;
  for (double step = 0.1; step > 1e-9; step /= 2.0) {
    if (moved(angle + step) < texels) angle += step;
  }
  return by(angle);
}

// Where the first view shows what the second one has at `at`, less that, straight from both projections.
Vec2 truth(const Rig& rig, const View& second_as_it_is, const Vec2& at) {
  Vec2 in_first;
  EXPECT_TRUE(project(rig.views[kFront], direction_at(second_as_it_is, at), in_first));
  Vec2 shown;
  EXPECT_TRUE(project(rig.views[kLeft], direction_at(rig.views[kFront], in_first), shown));
  return shown - at;
}

SeamMeasure measured(const Rig& rig, const GreyPicture& front, const GreyPicture& left, double noise = 2.0) {
  SeamMatch match(rig, kFront, kLeft);
  match.look(noisy(front, noise, 1), noisy(left, noise, 2));
  return match.measure();
}

TEST(SeamMatch, MeasuresWhatThePosesAreWrongBy) {
  const Rig rig = rig_of_cameras();
  const GreyPicture front = taken(rig.views[kFront], waves);
  for (const double texels : {0.0, 0.5, 1.5, 5.0, 9.0}) {
    const View left = turned(rig.views[kLeft], texels);
    const SeamMeasure found = measured(rig, front, taken(left, waves));
    ASSERT_TRUE(found.tells()) << texels;
    EXPECT_GT(found.shifts.size(), found.places() / 2) << texels;
    EXPECT_EQ(found.strays, 0U) << texels;
    std::vector<double> lengths;
    std::vector<double> across;
    double error = 0.0;
    for (const SeamShift& shift : found.shifts) {
      const Vec2 apart = truth(rig, left, shift.at);
      lengths.push_back(glm::length(apart));
      across.push_back(apart.x);
      error = std::max(error, glm::length(shift.apart - apart));
    }
    std::sort(lengths.begin(), lengths.end());
    std::sort(across.begin(), across.end());
    EXPECT_LT(error, std::max(0.3, 0.1 * texels)) << texels << ": of any place";
    EXPECT_NEAR(found.median, lengths[lengths.size() / 2], std::max(0.1, 0.03 * texels)) << texels;
    EXPECT_NEAR(found.median, texels, texels == 0.0 ? 0.1 : 0.25 * texels) << "the test turns it by that";
    EXPECT_NEAR(found.most, lengths[lengths.size() * 95 / 100], 0.2) << texels;
    EXPECT_NEAR(found.mostly.x, across[across.size() / 2], std::max(0.1, 0.03 * texels)) << texels;
  }
}

TEST(SeamMatch, DoesNotMindAnotherGainAndBlack) {
  const Rig rig = rig_of_cameras();
  const GreyPicture front = taken(rig.views[kFront], waves);
  const View left = turned(rig.views[kLeft], 1.5);
  const SeamMeasure same = measured(rig, front, taken(left, waves));
  const SeamMeasure darker =
      measured(rig, front, taken(left, [](const Vec3& d) { return 30.0 + 0.5 * waves(d); }));
  ASSERT_TRUE(darker.tells());
  EXPECT_NEAR(darker.median, same.median, 0.1);
}

TEST(SeamMatch, TakesOfSeveralLooksTheMedian) {
  const Rig rig = rig_of_cameras();
  const GreyPicture front = taken(rig.views[kFront], waves);
  const GreyPicture left = taken(rig.views[kLeft], waves);
  SeamMatch match(rig, kFront, kLeft);
  match.look(front, noisy(left, 2.0, 1));
  match.look(front, noisy(taken(turned(rig.views[kLeft], 5.0), waves), 2.0, 2));  // something shook it
  match.look(front, {kSize, std::vector<std::uint8_t>(left.texels.size(), 16)});
  match.look(front, noisy(left, 2.0, 3));
  const SeamMeasure found = match.measure();
  ASSERT_TRUE(found.tells());
  EXPECT_LT(found.median, 0.15);
  EXPECT_EQ(found.places(), SeamMatch::kMostPlaces);
}

TEST(SeamMatch, SaysWhereThereIsTooLittleTexture) {
  const Rig rig = rig_of_cameras();
  const auto grey = [](const Vec3&) { return 120.0; };
  // Lines that all run one way: along them nothing can be told.
  const auto meridians = [](const Vec3& d) { return 120.0 + 60.0 * std::cos(60.0 * std::atan2(d.x, d.z)); };
  const auto ramp = [](const Vec3& d) { return 120.0 + 90.0 * d.x; };
  for (const Brightness& world : {Brightness{grey}, Brightness{meridians}, Brightness{ramp}}) {
    const GreyPicture front = taken(rig.views[kFront], world);
    const GreyPicture left = taken(rig.views[kLeft], world);
    for (const double noise : {0.0, 2.0, 8.0}) {
      const SeamMeasure found = measured(rig, front, left, noise);
      EXPECT_FALSE(found.tells());
      EXPECT_GT(found.plain, found.places() * (noise > 5.0 ? 6 : 9) / 10) << noise;
    }
  }
  const GreyPicture covered{kSize, std::vector<std::uint8_t>(kSize.width * kSize.height, 16)};
  for (const double noise : {0.0, 2.0, 8.0}) {
    const SeamMeasure found = measured(rig, covered, taken(rig.views[kLeft], waves), noise);
    EXPECT_EQ(found.plain, found.places()) << "one of the cameras is covered";
  }
}

TEST(SeamMatch, DoesNotGuess) {
  const Rig rig = rig_of_cameras();
  const GreyPicture front = taken(rig.views[kFront], waves);
  const auto others = [](const Vec3& d) { return waves({d.z, d.x, d.y}); };
  const SeamMeasure different = measured(rig, front, taken(rig.views[kLeft], others));
  EXPECT_FALSE(different.tells()) << "pictures of different things";
  EXPECT_GT(different.unlike, different.places() / 2);
  const auto squares = [](const Vec3& d) {
    return 120.0 + 50.0 * std::cos(100.0 * std::atan2(d.x, d.z)) + 50.0 * std::cos(100.0 * std::asin(d.y));
  };
  const SeamMeasure again =
      measured(rig, taken(rig.views[kFront], squares), taken(turned(rig.views[kLeft], 3.0), squares));
  EXPECT_FALSE(again.tells()) << "the same over and over";
  EXPECT_GT(again.repeating, again.places() / 2);
  const SeamMeasure far_off = measured(rig, front, taken(turned(rig.views[kLeft], 30.0), waves));
  EXPECT_FALSE(far_off.tells()) << "beyond the reach";
  EXPECT_GT(far_off.unlike, far_off.places() / 2);
}

TEST(SeamMatch, LeavesOutWhatStandsElsewhere) {
  const Rig rig = rig_of_cameras();
  const GreyPicture front = taken(rig.views[kFront], waves);
  const View left = turned(rig.views[kLeft], 0.5);
  const SeamMeasure alone = measured(rig, front, taken(left, waves));
  // Something in a part of the seam that is five texels further on in one picture.
  const auto with_something_moving = [&](const Vec3& d) {
    const Vec3 there = glm::normalize(Vec3{-1.0, 0.45, -1.0});
    const Vec3 shifted = glm::normalize(d + 5.0 / 180.0 * Vec3{0.0, 1.0, 0.0});
    return glm::dot(d, there) > std::cos(0.25) ? waves(shifted) : waves(d);
  };
  const SeamMeasure found = measured(rig, front, taken(left, with_something_moving));
  ASSERT_TRUE(found.tells());
  EXPECT_EQ(alone.strays, 0U);
  EXPECT_GT(found.strays, 5U);
  EXPECT_NEAR(found.median, alone.median, 0.1);
  EXPECT_NEAR(found.most, alone.most, 0.2);
}

TEST(SeamMatch, MeetsAtTheDistanceWhereTheSeamsClose) {
  Rig rig = rig_of_cameras();
  rig.views[kFront].position_m = {0.0, 0.0, -0.06};
  rig.views[kLeft].position_m = {-0.06, 0.0, 0.0};
  constexpr double kSphere = 1.5;  // metres
  const auto from = [&](std::size_t view) {
    const Vec3 eye = rig.views[view].position_m / kSphere;
    return taken(rig.views[view], [eye](const Vec3& d) {
      const double along = glm::dot(eye, d);
      return waves(eye + d * (std::sqrt(along * along + 1.0 - glm::dot(eye, eye)) - along));
    });
  };
  const GreyPicture front = from(kFront);
  const GreyPicture left = from(kLeft);
  const SeamMeasure at_infinity = measured(rig, front, left);
  ASSERT_TRUE(at_infinity.tells());
  EXPECT_GT(at_infinity.median, 4.0);
  ASSERT_TRUE(set_shifts(rig.views, kSphere));
  const SeamMeasure there = measured(rig, front, left);
  ASSERT_TRUE(there.tells());
  EXPECT_LT(there.median, 0.2);
}

TEST(SeamMatch, KnowsViewsThatDoNotOverlap) {
  Rig rig = rig_of_cameras();
  EXPECT_TRUE(SeamMatch(rig, kFront, kLeft).overlap());
  EXPECT_FALSE(SeamMatch(rig, 1, 2).overlap()) << "left and right look away from each other";
  for (View& view : rig.views) view.focal = {0.5, 0.5};
  EXPECT_FALSE(SeamMatch(rig, kFront, kLeft).overlap()) << "faces of a cube only meet";
}

}  // namespace
}  // namespace cupola
