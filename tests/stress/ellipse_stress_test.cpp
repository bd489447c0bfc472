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

// A lens that hardly turns with r but once round with the angle: a pixel at radius r sees sin(phi) / r texels
// across and phi' along.
TEST(EllipseStress, AxesMayDifferTenThousandfold) {
  for (const double aspect : {1.0, 10.0, 100.0, 1e3, 1e4}) {
    Rig rig = test::omnimax_rig({4001, 4001}, 4001, {1024, 960}, kSix);
    // phi = c r: across 1 / r of sin(phi), which near the limb of a lens past 180 degrees vanishes.
    rig.frame.lens = {LensModel::kPolynomial, 0.0, {0.0, 3.1415}, {}};
    rig.frame.radius = 200.0;
    rig.frame.center = {2000.5, 2000.5};
    for (int i = 0; i < 40; ++i) {
      // sin(phi) / r against phi' = 3.14: of that ratio at phi = pi - e, e = 3.14 r / aspect.
      const double phi = 3.1415 - std::min(1.5, 3.1 / aspect) * (1.0 - 0.01 * i);
      ASSERT_TRUE(test::aim(rig, {std::sin(phi) * std::cos(i), std::sin(phi) * std::sin(i), -std::cos(phi)},
                            2000, 2000));
      EXPECT_GT(taps_like_the_reference(rig, 2000, 2000), 0U);
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
