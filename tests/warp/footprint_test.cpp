// The table builder's footprints against the reference's answers, texel by texel.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/footprint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pipeline/warp/ewa_exact.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

const std::vector<std::string> kAllNames = {"front", "left", "right", "top", "bottom", "back"};

// Applies the gathered weights to the faces.
std::array<double, 3> weighted(const std::vector<Tap>& taps, const test::Faces& faces) {
  std::array<double, 3> sum{};
  for (const Tap& tap : taps) {
    for (int channel = 0; channel < 3; ++channel) {
      sum[channel] += tap.weight * faces.images[tap.view].samples<std::uint8_t>(channel, tap.y)[tap.x];
    }
  }
  return sum;
}

void expect_equal_everywhere(const Rig& rig, int step, double bound = 1e-6) {
  const test::Faces faces = test::make_faces(rig, test::noise(3));
  const FootprintGatherer gatherer(rig);
  std::vector<Tap> taps;
  int compared = 0;
  for (int y = 0; y < rig.frame.size.height; ++y) {
    for (int x = y % step; x < rig.frame.size.width; x += step) {
      const Footprint found = gatherer.gather(x, y, taps);
      const auto exact = ewa_exact(rig, faces.images, x, y);
      const auto gathered = weighted(taps, faces);
      for (int channel = 0; channel < 3; ++channel) {
        ASSERT_NEAR(gathered[channel], exact[channel], bound)
            << x << ' ' << y << " kind " << static_cast<int>(found);
      }
      if (found != Footprint::kCovered) continue;
      double sum = 0;
      for (const Tap& tap : taps) {
        ASSERT_LE(std::abs(tap.weight), 2.0);
        ASSERT_TRUE(tap.weight > 0.0 || rig.filter.kernel != Kernel::kGaussian);
        sum += tap.weight;
      }
      ASSERT_NEAR(sum, 1.0, 1e-12);
      ++compared;
    }
  }
  EXPECT_GT(compared, 1000);
}

// Cameras that overlap by 20 degrees and more, one of them with a real lens.
Rig overlapping_rig() {
  Rig rig = test::omnimax_rig({180, 140}, 180, {120, 110}, {"front", "left", "right", "top"});
  for (View& view : rig.views) view.focal = {0.35, 0.38};
  rig.views[2].distortion = Distortion::kRadialTangential;
  rig.views[2].coefficients = {-0.05, 0.004, 0.001, -0.001, 0.0, 0.0, 0.0, 0.0};
  rig.views[2].limit = 2.5;
  return rig;
}

TEST(FootprintOf, FeatheredSeamsAreTheReferences) {
  for (const double feather_deg : {2.0, 12.0}) {
    Rig rig = overlapping_rig();
    rig.seams.feather_deg = feather_deg;
    expect_equal_everywhere(rig, 3);
    rig.filter = robidoux_filter();
    expect_equal_everywhere(rig, 7);
  }
}

// Eyes beside the centre, up to half the distance at which seams close.
Rig spread(Rig rig, double shift) {
  for (std::size_t v = 0; v < rig.views.size(); ++v) {
    View& view = rig.views[v];
    view.shift =
        shift * glm::normalize((v % 2 == 0 ? 0.8 : -0.5) * view.up + 0.4 * view.right - 0.5 * view.forward);
  }
  return rig;
}

TEST(FootprintOf, ViewsBesideTheCentreIsTheReferences) {
  for (const double shift : {0.02, 0.5}) {
    expect_equal_everywhere(spread(overlapping_rig(), shift), 7);
    expect_equal_everywhere(spread(test::omnimax_rig({120, 120}, 120, {90, 80}, kAllNames), shift), 3);
    Rig lobes = spread(overlapping_rig(), shift);
    lobes.filter = robidoux_filter();
    lobes.seams.feather_deg = 8.0;
    expect_equal_everywhere(lobes, 7);
    Rig wide = spread(test::omnimax_rig({48, 48}, 48, {160, 120}, kAllNames), shift);
    wide.filter = paper_preset();
    expect_equal_everywhere(wide, 1);
  }
}

// The pictures are grey, each of its own brightness: the frame goes from one to the next over the band.
TEST(FootprintOf, FeatheredSeamsGoFromOnePictureToTheNextWithoutSteps) {
  Rig rig = overlapping_rig();
  rig.filter = optimal_filter();
  const FootprintGatherer cut(rig);
  rig.seams.feather_deg = 12.0;
  const FootprintGatherer feathered(rig);
  const auto brightness = [](const FootprintGatherer& gatherer, int x, int y) {
    std::vector<Tap> taps;
    gatherer.gather(x, y, taps);
    double sum = 0.0;
    for (const Tap& tap : taps) sum += tap.weight * tap.view;
    return sum;
  };
  double step_cut = 0.0;
  double step_feathered = 0.0;
  const int y = rig.frame.size.height / 2;
  for (int x = 40; x < 140; ++x) {
    step_cut = std::max(step_cut, std::abs(brightness(cut, x + 1, y) - brightness(cut, x, y)));
    step_feathered =
        std::max(step_feathered, std::abs(brightness(feathered, x + 1, y) - brightness(feathered, x, y)));
  }
  EXPECT_GT(step_cut, 0.5);
  EXPECT_LT(step_feathered, 0.3);
}

TEST(FootprintOf, PaperGeometryIsTheReferences) {
  expect_equal_everywhere(test::paper_rig({256, 240}), 37);
}

TEST(FootprintOf, KernelsWithLobesAreTheReferences) {
  for (const FilterSettings& filter : {robidoux_filter(), jinc_filter()}) {
    Rig paper = test::paper_rig({256, 240});
    paper.filter = filter;
    expect_equal_everywhere(paper, 37);
    // No top and no bottom: footprints end where the views do.
    Rig cube = test::omnimax_rig({120, 120}, 120, {50, 50}, {"front", "left", "right"});
    cube.filter = filter;
    expect_equal_everywhere(cube, 1);
    for (View& view : cube.views) view.size = {9, 400};
    expect_equal_everywhere(cube, 1, 1e-5);
  }
}

TEST(FootprintOf, WholeCubeWithCornersIsTheReferences) {
  expect_equal_everywhere(test::omnimax_rig({120, 120}, 120, {50, 50}, kAllNames), 1);
}

TEST(FootprintOf, WideFootprintsAcrossSeamsAreTheReferences) {
  Rig rig = test::omnimax_rig({48, 48}, 48, {160, 120}, kAllNames);
  rig.filter = paper_preset();
  expect_equal_everywhere(rig, 1);
}

TEST(FootprintOf, MagnifiedFacesAreTheReferences) {
  Rig rig = test::omnimax_rig({200, 200}, 200, {12, 9}, kAllNames);
  rig.filter.radius = 1.5;
  expect_equal_everywhere(rig, 3);
}

TEST(FootprintOf, OverlappingViewsAreTheReferences) {
  Rig rig = test::omnimax_rig({128, 128}, 128, {90, 90}, {"front", "left", "right", "top", "bottom"});
  for (View& view : rig.views) view.focal = {0.4, 0.42};
  expect_equal_everywhere(rig, 1);
}

TEST(FootprintOf, TwoWideViewsAreTheReferences) {
  Rig rig = test::omnimax_rig({128, 128}, 128, {300, 200}, {"left", "right"});
  for (View& view : rig.views) {
    const double side = view.forward.x;
    view.forward = glm::normalize(Vec3{side, 0, -1});
    view.right = glm::normalize(glm::cross(view.forward, Vec3{0, 1, 0}));
    view.focal = {0.5 / std::tan(0.95), 0.5 / std::tan(1.2)};
  }
  expect_equal_everywhere(rig, 1, 1e-5);
}

TEST(FootprintOf, CalibratedCamerasAreTheReferences) {
  Rig rig = test::omnimax_rig({128, 128}, 128, {96, 80}, {"front", "left", "right", "top"});
  for (View& view : rig.views) {
    view.focal = {0.42, 0.44};
    view.distortion = Distortion::kRadialTangential;
    view.coefficients = {-0.05, 0.01, 0.001, -0.001, 0.0};
    view.limit = 3.0;
  }
  rig.views[1].distortion = Distortion::kFisheye;
  rig.views[1].coefficients = {-0.01, 0.001, 0.0, 0.0};
  rig.views[1].focal = {0.45, 0.45};
  expect_equal_everywhere(rig, 1, 1e-5);
}

// Sides of 41 and 43: with 40 texels over 30 pixels some centres lie on the footprints' very edge.
TEST(FootprintOf, OtherProjectionsAreTheReferences) {
  for (const FrameModel model : {FrameModel::kEquirectangular, FrameModel::kCylindrical,
                                 FrameModel::kMercator, FrameModel::kChromeBall, FrameModel::kCube}) {
    Rig rig = test::omnimax_rig({90, 60}, 60, {41, 43}, kAllNames);
    rig.frame.model = model;
    rig.frame.fov = 6.283185307179586;
    rig.frame.columns = 3;
    rig.frame.faces = rig.views;
    for (View& face : rig.frame.faces) face.size = {30, 30};
    SCOPED_TRACE(static_cast<int>(model));
    expect_equal_everywhere(rig, 1, 1e-5);
  }
}

}  // namespace
}  // namespace cupola
