// Pyramids, two passes and summed areas: their error against the reference and their odd cases.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/frame_warp.h"
#include "pipeline/warp/rank_one.h"
#include "pipeline/warp/two_pass_plan.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

const std::vector<std::string> kFour = {"front", "left", "right", "top"};

constexpr Method kOthers[] = {Method::kEwaPyramid, Method::kTwoPass, Method::kTrilinear, Method::kSummedArea};

std::string test_name(Method method) {
  std::string name(kMethodNames[static_cast<std::size_t>(method)]);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

ImageBuffer warped(const Rig& rig, Method method, const test::Faces& faces, PixelFormat format,
                   int threads = 2) {
  WorkerPool pool(threads);
  ImageBuffer frame(format, rig.frame.size);
  make_frame_warp(rig, method, Cpu::kScalar, pool)->warp(faces.images, frame.pixels());
  return frame;
}

TEST(OtherMethods, TakeTheDefaultGaussianInPlaceOfKernelsWithLobes) {
  Rig rig = test::omnimax_rig({123, 90}, 123, {80, 80}, kFour);
  const test::Faces faces = test::make_faces(rig, test::noise(5));
  for (const Method method : kOthers) {
    rig.filter = default_gaussian();
    const ImageBuffer gaussian = warped(rig, method, faces, PixelFormat::kRgbPlanar8);
    for (const FilterSettings& lobed : {robidoux_filter(), jinc_filter(), optimal_filter()}) {
      rig.filter = lobed;
      const ImageBuffer frame = warped(rig, method, faces, PixelFormat::kRgbPlanar8);
      EXPECT_TRUE(test::same_pixels(frame.pixels(), gaussian.pixels())) << test_name(method);
    }
  }
}

struct Bound {
  Method method;
  int face;  // texels; the circle has 246 pixels, 128 are 1:1
  double rms, max;
};

class OtherMethodError : public testing::TestWithParam<Bound> {};

TEST_P(OtherMethodError, StaysWithinItsBoundOfTheReferenceOnNoise) {
  const Bound& bound = GetParam();
  WorkerPool pool(2);
  const Rig rig = test::omnimax_rig({246, 180}, 246, {bound.face, bound.face}, kFour);
  const test::Faces faces = test::make_faces(rig, test::noise(4));
  const ImageBuffer frame = warped(rig, bound.method, faces, PixelFormat::kRgbPlanar8);
  const test::Difference d = test::difference(rig, frame.pixels(), ewa_exact_frame(rig, faces.images, pool));
  std::printf("%s %d: rms %.3f, max %.2f LSB\n", test_name(bound.method).c_str(), bound.face, d.rms, d.max);
  EXPECT_LE(d.rms, bound.rms);
  EXPECT_LE(d.max, bound.max) << "at " << d.x << ' ' << d.y;
}

INSTANTIATE_TEST_SUITE_P(
    Bounds, OtherMethodError,
    testing::Values(Bound{Method::kEwaPyramid, 128, 0.30, 0.6}, Bound{Method::kEwaPyramid, 256, 0.30, 0.6},
                    Bound{Method::kEwaPyramid, 512, 1.9, 15}, Bound{Method::kEwaPyramid, 1024, 1.3, 11},
                    Bound{Method::kTwoPass, 128, 1.0, 12}, Bound{Method::kTwoPass, 512, 0.75, 6},
                    Bound{Method::kTrilinear, 128, 21, 105}, Bound{Method::kTrilinear, 512, 15, 85},
                    Bound{Method::kSummedArea, 128, 21, 110}, Bound{Method::kSummedArea, 512, 10.5, 50}),
    [](const auto& instance) {
      return test_name(instance.param.method) + "_" + std::to_string(instance.param.face);
    });

class OtherMethod : public testing::TestWithParam<Method> {};

TEST_P(OtherMethod, GivesTheSameFrameOnAnyNumberOfThreads) {
  const Rig rig = test::omnimax_rig({150, 110}, 150, {203, 190}, kFour);
  const test::Faces faces = test::make_faces(rig, test::noise(6));
  const ImageBuffer one = warped(rig, GetParam(), faces, PixelFormat::kXrgb8888, 1);
  const ImageBuffer three = warped(rig, GetParam(), faces, PixelFormat::kXrgb8888, 3);
  EXPECT_TRUE(test::same_pixels(one.pixels(), three.pixels()));
}

TEST_P(OtherMethod, KeepsEvenColoursAtAnySizeOfTheFaces) {
  for (const Size face : {Size{1, 1}, Size{1, 7}, Size{5, 3}, Size{67, 131}, Size{401, 257}}) {
    const Rig rig =
        test::omnimax_rig({61, 47}, 61, face, {"front", "left", "right", "top", "bottom", "back"});
    for (const PixelFormat format : {PixelFormat::kRgbPlanar8, PixelFormat::kRgbPlanar16}) {
      for (const unsigned value : {1U, 127U, format == PixelFormat::kRgbPlanar8 ? 255U : 65535U}) {
        const test::Faces faces = test::make_faces(
            rig, [&](int, int channel, int, int) { return value - (channel == 1 ? 1U : 0U); }, format);
        const ImageBuffer frame = warped(rig, GetParam(), faces, format);
        for (int y = 0; y < 47; ++y) {
          for (int x = 0; x < 61; ++x) {
            DirectionAndSlope looking;
            const bool inside = ray(rig.frame, {x + 0.5, y + 0.5}, looking);
            for (int channel = 0; channel < 3; ++channel) {
              const unsigned got = format == PixelFormat::kRgbPlanar8
                                       ? frame.pixels().samples<std::uint8_t>(channel, y)[x]
                                       : frame.pixels().samples<std::uint16_t>(channel, y)[x];
              const unsigned expected = inside ? value - (channel == 1 ? 1U : 0U) : 0U;
              ASSERT_EQ(got, expected) << face.width << 'x' << face.height << " at " << x << ' ' << y;
            }
          }
        }
      }
    }
  }
}

TEST_P(OtherMethod, KeepsTheBrightestColourWhereThousandsOfTexelsMakeAPixel) {
  const Rig rig =
      test::omnimax_rig({5, 4}, 5, {800, 600}, {"front", "left", "right", "top", "bottom", "back"});
  const test::Faces faces = test::make_faces(
      rig, [](int, int, int, int) { return 65535U; }, PixelFormat::kRgbPlanar16);
  const ImageBuffer frame = warped(rig, GetParam(), faces, PixelFormat::kRgbPlanar16);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 5; ++x) {
      DirectionAndSlope looking;
      const bool inside = ray(rig.frame, {x + 0.5, y + 0.5}, looking);
      ASSERT_EQ(frame.pixels().samples<std::uint16_t>(0, y)[x], inside ? 65535U : 0U) << x << ' ' << y;
    }
  }
}

TEST_P(OtherMethod, ReadsNothingOutsideWhatItNeedsWhenThePictureShrinks) {
  WorkerPool pool(2);
  const Rig rig = test::omnimax_rig({100, 73}, 100, {301, 299}, kFour);
  const auto warp = make_frame_warp(rig, GetParam(), Cpu::kScalar, pool);
  const test::Faces clean = test::make_faces(rig, test::noise(7, 65535), PixelFormat::kRgbPlanar16);
  const test::Faces poisoned = test::make_faces(
      rig,
      [&](int view, int channel, int x, int y) {
        const RowSpan& row = warp->needed()[view].rows[y];
        return x >= row.first && x < row.last ? clean.images[view].samples<std::uint16_t>(channel, y)[x]
                                              : 65535U;
      },
      PixelFormat::kRgbPlanar16);
  ImageBuffer a(PixelFormat::kRgb16, rig.frame.size);
  ImageBuffer b(PixelFormat::kRgb16, rig.frame.size);
  warp->warp(clean.images, a.pixels());
  warp->warp(poisoned.images, b.pixels());
  EXPECT_TRUE(test::same_pixels(as_const(a.pixels()), as_const(b.pixels())));
}

TEST_P(OtherMethod, GivesSixteenBitsTheSamePictureFiner) {
  const Rig rig = test::omnimax_rig({120, 88}, 120, {200, 200}, kFour);
  const test::Faces narrow = test::make_faces(rig, test::noise(8));
  const test::Faces wide = test::make_faces(
      rig,
      [&](int view, int channel, int x, int y) {
        return 257U * narrow.images[view].samples<std::uint8_t>(channel, y)[x];
      },
      PixelFormat::kRgbPlanar16);
  const ImageBuffer a = warped(rig, GetParam(), narrow, PixelFormat::kRgbPlanar8);
  const ImageBuffer b = warped(rig, GetParam(), wide, PixelFormat::kRgbPlanar16);
  for (int y = 0; y < 88; ++y) {
    for (int x = 0; x < 120; ++x) {
      EXPECT_NEAR(a.pixels().samples<std::uint8_t>(0, y)[x],
                  b.pixels().samples<std::uint16_t>(0, y)[x] / 257.0, 0.52);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, OtherMethod, testing::ValuesIn(kOthers),
                         [](const auto& instance) { return test_name(instance.param); });

TEST(SummedArea, IsTheMeanOverTheRectangleAroundThePixel) {
  // A cube's atlas of its own faces at a third of their size: every pixel is 3 x 3 texels.
  Rig rig = test::omnimax_rig({20, 20}, 20, {60, 60}, {"front"});
  rig.frame.model = FrameModel::kCube;
  rig.frame.columns = 1;
  rig.frame.faces = {rig.views[0]};
  rig.frame.faces[0].size = {20, 20};
  const test::Faces faces = test::make_faces(rig, test::noise(9));
  const ImageBuffer frame = warped(rig, Method::kSummedArea, faces, PixelFormat::kRgbPlanar8);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      unsigned sum = 0;
      for (int i = 0; i < 9; ++i) {
        sum += faces.images[0].samples<std::uint8_t>(2, 3 * y + i / 3)[3 * x + i % 3];
      }
      EXPECT_NEAR(frame.pixels().samples<std::uint8_t>(2, y)[x], sum / 9.0, 0.501);
    }
  }
}

TEST(RankOne, FindsTheProductThatAMatrixIs) {
  DenseMatrix w{3, 4, {}};
  const double b[3] = {0.5, 2.0, 1.0};
  const double a[4] = {0.1, 0.4, 0.3, 0.2};
  for (const double row : b) {
    for (const double column : a) w.entries.push_back(row * column);
  }
  RankOne fit;
  fit_rank_one(w, 0, 3, fit);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(fit.b[i], b[i], 1e-12);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(fit.a[i], a[i], 1e-12);
  EXPECT_NEAR(fit.residual, 0.0, 1e-12);
}

TEST(RankOne, LosesWhatTheSecondSingularValueHolds) {
  RankOne fit;
  fit_rank_one({2, 2, {2.0, 1.0, 1.0, 2.0}}, 0, 2, fit);  // singular values 3 and 1
  EXPECT_NEAR(fit.energy, 10.0, 1e-12);
  EXPECT_NEAR(fit.residual, 1.0, 1e-9);
}

TEST(TwoPass, StandsAcrossForTheSideFaces) {
  WorkerPool pool(2);
  const TwoPassPlan plan = plan_two_pass(test::omnimax_rig({246, 180}, 246, {128, 128}, kFour), pool);
  // Left of the frame's centre, up is up, but where most of the face's pixels are, near the frame's corner,
  // the face is turned by more than 45 degrees: its columns are summed for the frame's rows.
  EXPECT_EQ(plan.orders[1], PassOrder::kColumnsForRows);
  EXPECT_EQ(plan.orders[2], PassOrder::kColumnsForRows);
  EXPECT_EQ(plan.orders[3], PassOrder::kRowsForColumns);
  const double samples = static_cast<double>(plan.samples.size()) / (246 * 180);
  std::printf("samples of the first pass: %.2f a pixel\n", samples);
  EXPECT_LT(samples, 1.3) << "the pixels of a line share them";
}

}  // namespace
}  // namespace cupola
