// Pyramid levels and the taps on them: sizes, sums, cost.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <numeric>

#include "pipeline/warp/frame_warp.h"
#include "pipeline/warp/pyramid_plan.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

const std::vector<std::string> kFour = {"front", "left", "right", "top"};

// Texels a covered pixel, on all levels together.
double taps_a_pixel(const PyramidPlan& plan) {
  std::size_t pixels = 0;
  for (std::size_t i = 0; i + 1 < plan.taps.starts.size(); ++i) {
    if (plan.taps.starts[i].run != plan.taps.starts[i + 1].run) ++pixels;
  }
  return static_cast<double>(plan.taps.taps()) / static_cast<double>(pixels);
}

TEST(ReduceLine, TakesWeightedMeansCentredOnTheOutput) {
  for (const Reduction reduction : {Reduction::kBox, Reduction::kGaussian}) {
    for (const int from : {1, 2, 3, 7, 64, 101}) {
      const int to = std::max(1, (from + 1) / 2);
      const LineReduction line = reduce_line(from, to, reduction, 0.0);
      ASSERT_EQ(line.taps.size(), static_cast<std::size_t>(to));
      for (int i = 0; i < to; ++i) {
        const ReductionTaps& taps = line.taps[static_cast<std::size_t>(i)];
        ASSERT_GE(taps.first, 0);
        ASSERT_LE(taps.first + taps.count, from);
        const std::uint16_t* weights = line.weights.data() + taps.weights;
        EXPECT_EQ(std::accumulate(weights, weights + taps.count, 0), 1 << 14);
        if (i < 4 || i >= to - 4) continue;  // cut at the edge
        double mean = 0.0;
        for (int k = 0; k < taps.count; ++k) mean += (taps.first + k + 0.5) * weights[k] / (1 << 14);
        EXPECT_NEAR(mean, (i + 0.5) * from / to, 0.01);
      }
    }
  }
}

TEST(Pyramid, MakesTheMeanOfFourTexelsByBoxes) {
  WorkerPool pool(2);
  const Rig rig = test::omnimax_rig({40, 40}, 40, {64, 48}, {"front"});
  const PyramidShape shape = shape_pyramid(rig, Reduction::kBox);
  ASSERT_EQ(shape.levels.size(), 7U);
  std::vector<TexelSpans> used;
  for (const PyramidLevel& level : shape.levels) {
    used.push_back(TexelSpans::none(level.sizes[0]));
    for (int y = 0; y < level.sizes[0].height; ++y) used.back().add(y, {0, level.sizes[0].width});
  }
  Pyramid pyramid(shape, used);
  const test::Faces faces = test::make_faces(rig, test::noise(2));
  pyramid.build(faces.images, pool);
  const Image level = pyramid.image(1);
  ASSERT_EQ(level.size, (Size{32, 24}));
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 32; ++x) {
      unsigned sum = 0;
      for (int i = 0; i < 4; ++i) {
        sum += faces.images[0].samples<std::uint8_t>(1, 2 * y + i / 2)[2 * x + i % 2];
      }
      EXPECT_NEAR(level.samples<std::uint16_t>(1, y)[x], sum * 64.0, 1.0);
    }
  }
}

TEST(EwaPyramid, UsesTheFacesAloneWhereNothingShrinks) {
  WorkerPool pool(2);
  const Rig rig = test::omnimax_rig({246, 180}, 246, {128, 128}, kFour);
  const PyramidPlan plan = plan_ewa_pyramid(rig, pool);
  for (const TapRuns::Run& run : plan.taps.runs) ASSERT_LT(run.image, 4);
}

TEST(EwaPyramid, CostsAtEightToOneAtMostTwiceWhatItCostsAtOneToOne) {
  WorkerPool pool(2);
  const double at_one =
      taps_a_pixel(plan_ewa_pyramid(test::omnimax_rig({246, 180}, 246, {128, 128}, kFour), pool));
  const double at_eight =
      taps_a_pixel(plan_ewa_pyramid(test::omnimax_rig({246, 180}, 246, {1024, 1024}, kFour), pool));
  const double at_sixteen =
      taps_a_pixel(plan_ewa_pyramid(test::omnimax_rig({246, 180}, 246, {2048, 2048}, kFour), pool));
  std::printf("taps a pixel: %.2f at 1:1, %.2f at 8:1, %.2f at 16:1\n", at_one, at_eight, at_sixteen);
  EXPECT_LE(at_eight, 2.0 * at_one);
  EXPECT_LE(at_sixteen, 2.0 * at_one);
}

TEST(EwaPyramid, MakesOnlyWhatSomePixelUses) {
  WorkerPool pool(2);
  const Rig rig = test::omnimax_rig({123, 90}, 123, {512, 512}, kFour);
  const PyramidPlan plan = plan_ewa_pyramid(rig, pool);
  const Pyramid pyramid(plan.shape, texels_used(plan.shape, plan.taps));
  std::int64_t made = 0;
  std::int64_t whole = 0;
  for (std::size_t image = 4; image < plan.shape.levels.size() * 4; ++image) {
    made += pyramid.made(image).texels();
    whole += pyramid.made(image).size.width * pyramid.made(image).size.height;
  }
  std::int64_t faces = 0;
  for (const NeededRegion& region : pyramid.needed()) faces += region.texels();
  std::printf("levels: %ld of %ld texels, faces %ld\n", static_cast<long>(made), static_cast<long>(whole),
              static_cast<long>(faces));
  EXPECT_LT(made, whole / 3);
  EXPECT_LT(faces, 4 * 512 * 512 * 7 / 10);
}

}  // namespace
}  // namespace cupola
