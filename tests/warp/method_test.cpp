// The methods beside the table: what they are, checked where they have simple answers.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/frame/error.h"
#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/frame_warp.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

const std::vector<std::string> kAllNames = {"front", "left", "right", "top", "bottom", "back"};

class EveryMethod : public testing::TestWithParam<Method> {
 protected:
  ImageBuffer warped(const Rig& rig, const test::Faces& faces,
                     PixelFormat format = PixelFormat::kRgbPlanar8) {
    ImageBuffer frame(format, rig.frame.size);
    make_frame_warp(rig, GetParam(), best_cpu(), pool_)->warp(faces.images, frame.pixels());
    return frame;
  }
  WorkerPool pool_{2};
};

TEST_P(EveryMethod, KeepsEvenColoursAndLeavesTheOutsideBlack) {
  const Rig rig = test::omnimax_rig({90, 70}, 90, {40, 44}, kAllNames);
  for (const PixelFormat format : {PixelFormat::kRgbPlanar8, PixelFormat::kRgbPlanar16}) {
    const unsigned value = format == PixelFormat::kRgbPlanar8 ? 201U : 54321U;
    const test::Faces faces = test::make_faces(
        rig, [&](int, int, int, int) { return value; }, format);
    const ImageBuffer frame = warped(rig, faces, format);
    for (int y = 0; y < 70; ++y) {
      for (int x = 0; x < 90; ++x) {
        DirectionAndSlope looking;
        const unsigned expected = ray(rig.frame, {x + 0.5, y + 0.5}, looking) ? value : 0;
        const unsigned got = format == PixelFormat::kRgbPlanar8
                                 ? frame.pixels().samples<std::uint8_t>(0, y)[x]
                                 : frame.pixels().samples<std::uint16_t>(0, y)[x];
        ASSERT_EQ(got, expected) << x << ' ' << y;
      }
    }
  }
}

TEST_P(EveryMethod, ReadsNothingOutsideWhatItSaysItNeeds) {
  const Rig rig = test::omnimax_rig({300, 220}, 300, {96, 96}, {"front", "left", "right", "top"});
  const auto warp = make_frame_warp(rig, GetParam(), best_cpu(), pool_);
  const test::Faces clean = test::make_faces(rig, test::noise(5));
  const test::Faces poisoned = test::make_faces(rig, [&](int view, int channel, int x, int y) {
    const RowSpan& row = warp->needed()[view].rows[y];
    return x >= row.first && x < row.last ? clean.images[view].samples<std::uint8_t>(channel, y)[x] : 255U;
  });
  ImageBuffer a(PixelFormat::kRgb8, rig.frame.size);
  ImageBuffer b(PixelFormat::kRgb8, rig.frame.size);
  warp->warp(clean.images, a.pixels());
  warp->warp(poisoned.images, b.pixels());
  EXPECT_TRUE(test::same_pixels(as_const(a.pixels()), as_const(b.pixels())));
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod,
                         testing::Values(Method::kEwa, Method::kEwaExact, Method::kEwaScan,
                                         Method::kEwaScanInteger, Method::kEwaPyramid, Method::kTwoPass,
                                         Method::kTrilinear, Method::kSummedArea, Method::kBilinear,
                                         Method::kNearest),
                         [](const auto& instance) {
                           std::string name(kMethodNames[static_cast<std::size_t>(instance.param)]);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(NearestMethod, TakesTheTexelUnderTheRay) {
  WorkerPool pool(1);
  const Rig rig = test::omnimax_rig({100, 100}, 100, {32, 32}, kAllNames);
  const test::Faces faces = test::make_faces(rig, test::noise(8));
  ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
  make_frame_warp(rig, Method::kNearest, Cpu::kScalar, pool)->warp(faces.images, frame.pixels());
  for (int y = 0; y < 100; y += 3) {
    for (int x = 0; x < 100; x += 3) {
      DirectionAndSlope looking;
      if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking)) continue;
      const int view = owner(rig.views, looking.direction);
      Vec2 uv;
      ASSERT_TRUE(project(rig.views[view], looking.direction, uv));
      const Vec2 f = uv - glm::floor(uv);
      if (std::min({f.x, f.y, 1 - f.x, 1 - f.y}) < 1e-4) continue;  // positions are kept as floats
      EXPECT_EQ(frame.pixels().samples<std::uint8_t>(2, y)[x],
                faces.images[view].samples<std::uint8_t>(2, static_cast<int>(uv.y))[static_cast<int>(uv.x)]);
    }
  }
}

TEST(BilinearMethod, ReproducesALinearRamp) {
  WorkerPool pool(1);
  const Rig rig = test::omnimax_rig({100, 100}, 200, {64, 64}, {"front"});
  const test::Faces faces =
      test::make_faces(rig, [](int, int, int x, int y) { return static_cast<unsigned>(2 * x + y); });
  ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
  make_frame_warp(rig, Method::kBilinear, Cpu::kScalar, pool)->warp(faces.images, frame.pixels());
  int compared = 0;
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      DirectionAndSlope looking;
      Vec2 uv;
      if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking) || owner(rig.views, looking.direction) < 0 ||
          !project(rig.views[0], looking.direction, uv) || std::min(uv.x, uv.y) < 1 ||
          std::max(uv.x, uv.y) > 63) {
        continue;
      }
      ++compared;
      EXPECT_NEAR(frame.pixels().samples<std::uint8_t>(0, y)[x], 2 * (uv.x - 0.5) + uv.y - 0.5, 0.501);
    }
  }
  EXPECT_GT(compared, 500);
}

TEST(SplitWarp, HasEachMethodInItsHalf) {
  WorkerPool pool(2);
  const Rig rig = test::omnimax_rig({101, 80}, 100, {48, 48}, {"front", "left", "right", "top"});
  const test::Faces faces = test::make_faces(rig, test::noise(10));
  ImageBuffer split(PixelFormat::kRgb8, rig.frame.size);
  ImageBuffer whole(PixelFormat::kRgb8, rig.frame.size);
  make_split_warp(rig, Method::kNearest, Method::kEwa, best_cpu(), pool)->warp(faces.images, split.pixels());
  const auto same_part = [&](Method method, int x, int width) {
    make_frame_warp(rig, method, best_cpu(), pool)->warp(faces.images, whole.pixels());
    return test::same_pixels(part_of(as_const(split.pixels()), x, 0, {width, 80}),
                             part_of(as_const(whole.pixels()), x, 0, {width, 80}));
  };
  EXPECT_TRUE(same_part(Method::kNearest, 0, 50));
  EXPECT_TRUE(same_part(Method::kEwa, 50, 51));
  Rig map = rig;
  map.frame.model = FrameModel::kMercator;
  EXPECT_THROW(make_split_warp(map, Method::kNearest, Method::kEwa, best_cpu(), pool), InputError);
}

class ScanMethod : public testing::TestWithParam<Method> {};

TEST_P(ScanMethod, IsTheReferenceWithinItsTablesStepsAwayFromSeams) {
  WorkerPool pool(2);
  const Rig rig = test::omnimax_rig({200, 146}, 200, {104, 104}, {"front", "left", "right", "top"});
  const test::Faces faces = test::make_faces(rig, test::noise(9));
  ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
  make_frame_warp(rig, GetParam(), Cpu::kScalar, pool)->warp(faces.images, frame.pixels());
  double squares = 0;
  int compared = 0;
  for (int y = 0; y < 146; ++y) {
    for (int x = 0; x < 200; ++x) {
      DirectionAndSlope looking;
      Vec2 uv;
      if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking)) continue;
      const int view = owner(rig.views, looking.direction);
      ASSERT_TRUE(project(rig.views[view], looking.direction, uv));
      if (std::min(uv.x, uv.y) < 4 || std::max(uv.x, uv.y) > 100) continue;
      const double error =
          frame.pixels().samples<std::uint8_t>(0, y)[x] - ewa_exact(rig, faces.images, x, y)[0];
      EXPECT_LT(std::abs(error), 1.0) << x << ' ' << y;
      squares += error * error;
      ++compared;
    }
  }
  EXPECT_GT(compared, 10000);
  EXPECT_LT(std::sqrt(squares / compared), 0.30) << "rounding to 8 bits alone gives 0.289";
}

INSTANTIATE_TEST_SUITE_P(Numbers, ScanMethod, testing::Values(Method::kEwaScan, Method::kEwaScanInteger),
                         [](const auto& instance) {
                           return instance.param == Method::kEwaScan ? "floating_point" : "integers";
                         });

}  // namespace
}  // namespace cupola
