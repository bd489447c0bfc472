// Footprints of extreme shape and size: thin ones, tiny ones, and those of more texels than a table takes.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "pipeline/frame/error.h"
#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/footprint.h"
#include "pipeline/warp/table_build.h"
#include "tests/stress/random_rigs.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

const std::vector<std::string> kSix = {"front", "left", "right", "top", "bottom", "back"};

const test::NoiseFaces& noise() {
  static const test::NoiseFaces shared(9);
  return shared;
}

// The footprint's taps; the reference agrees to a millionth.
std::size_t taps_like_the_reference(const Rig& rig, int x, int y) {
  const std::vector<Image> faces = noise().faces(rig);
  std::vector<Tap> taps;
  FootprintGatherer(rig).gather(x, y, taps);
  const auto exact = ewa_exact(rig, faces, x, y);
  double sum = 0.0;
  for (const Tap& tap : taps) sum += tap.weight * faces[tap.view].samples<std::uint8_t>(0, tap.y)[tap.x];
  EXPECT_NEAR(sum, exact[0], 1e-6 * std::max(1.0, exact[0]))
      << x << ' ' << y << ": " << taps.size() << " taps";
  return taps.size();
}

// Near phi = pi a step along r turns the ray by phi', one across by next to nothing: there the axis is raised
// to 0.75 texels, and the frame's radius sets the other. Upright or nearly, so that boxes stay small.
TEST(EllipseStress, AxesMayDifferTenThousandfold) {
  for (const double aspect : {1.0, 10.0, 100.0, 1e3, 1e4}) {
    Rig rig = test::omnimax_rig({101, 101}, 101, {65535, 65535}, {"front", "back"});
    rig.filter.rec = 0.0;
    rig.frame.lens = {LensModel::kPolynomial, 0.0, {0.0, 3.1415}, {}};
    rig.frame.radius = 3.1415 * 65535 / 2 / (0.75 * aspect);
    for (int i = 0; i < 12; ++i) {
      const double turn = i % 4 * 1.5707963267948966 + i * 1e-5;
      const double phi = 3.1415 - 1e-6 * i - 1e-9;
      const Vec3 d{std::sin(phi) * std::cos(turn), std::sin(phi) * std::sin(turn), -std::cos(phi)};
      ASSERT_TRUE(test::aim(rig, d, 50, 50));
      const auto taps = static_cast<double>(taps_like_the_reference(rig, 50, 50));
      EXPECT_GE(taps, aspect) << "half of pi 0.75^2 aspect";
      EXPECT_LE(taps, 3.0 * aspect + 4.0);
    }
  }
}

TEST(EllipseStress, TheLimbOfAChromeBallIsFinite) {
  Rig rig = test::omnimax_rig({201, 201}, 200, {64, 64}, kSix);
  rig.frame.model = FrameModel::kChromeBall;
  for (const double inside : {0.0, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4}) {
    for (int i = 0; i < 24; ++i) {
      rig.frame.center = {100.5 - (1.0 - inside) * 100.0 * std::cos(i),
                          100.5 - (1.0 - inside) * 100.0 * std::sin(i)};
      taps_like_the_reference(rig, 100, 100);
    }
  }
}

TEST(EllipseStress, FromSixteenTexelsAFaceToFramesOf8192Pixels) {
  Rig rig = test::omnimax_rig({8192, 8192}, 8192, {16, 16}, kSix);
  test::Dice dice(1);
  for (int i = 0; i < 2000; ++i) taps_like_the_reference(rig, dice.whole(0, 8191), dice.whole(0, 8191));
}

TEST(EllipseStress, FromFacesOf16384TexelsToFramesOf64Pixels) {
  Rig rig = test::omnimax_rig({64, 64}, 64, {16384, 16384}, kSix);
  rig.filter.radius = 0.25;
  rig.filter.rec = 0.0;
  EXPECT_GT(taps_like_the_reference(rig, 32, 32), 10'000U);
  EXPECT_GT(taps_like_the_reference(rig, 32, 45), 10'000U);  // about where front meets bottom
}

TEST(EllipseStress, MoreTexelsThanATableTakesAreRefusedAtOnce) {
  WorkerPool pool(1);
  for (const FilterSettings& filter : {FilterSettings{}, paper_preset()}) {
    Rig rig = test::omnimax_rig({64, 64}, 64, {16384, 16384}, kSix);
    rig.filter = filter;
    std::vector<Tap> taps;
    FootprintGatherer(rig).gather(32, 32, taps);
    EXPECT_GT(taps.size(), static_cast<std::size_t>(kMostTaps));
    EXPECT_LT(taps.size(), static_cast<std::size_t>(kMostTaps) + 65536) << "given up half-way";
    EXPECT_THROW(build_warp_table(rig, pool), InputError);
  }
}

}  // namespace
}  // namespace cupola
