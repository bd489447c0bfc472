// Every kernel against the scalar one: same bits on real tables, random sizes and the worst texels.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

const std::vector<std::string> kAllNames = {"front", "left", "right", "top", "bottom", "back"};

ImageBuffer warped(const WarpTable& table, const test::Faces& faces, Cpu cpu, WorkerPool& pool,
                   PixelFormat format = PixelFormat::kRgbPlanar8) {
  ImageBuffer frame(format, table.frame);
  // Left over from the frame before: every pixel must be written.
  for (int plane = 0; plane < plane_count(format); ++plane) {
    for (int y = 0; y < table.frame.height; ++y) {
      std::byte* row = frame.pixels().planes[plane].row(y);
      std::fill(row, row + static_cast<std::ptrdiff_t>(table.frame.width) * pixel_step(format),
                std::byte{0xa5});
    }
  }
  make_table_warp(table, cpu, pool)->warp(faces.images, frame.pixels());
  return frame;
}

class EveryCpu : public testing::TestWithParam<Cpu> {
 protected:
  void SetUp() override {
    if (!supported(GetParam())) GTEST_SKIP() << "this machine has no " << name(GetParam());
  }
  WorkerPool pool_{2};
};

TEST_P(EveryCpu, GivesTheScalarBitsOverRandomRigsAndSizes) {
  std::mt19937 random(11);
  for (int i = 0; i < 30; ++i) {
    const auto side = [&](int least, int most) {
      return std::uniform_int_distribution<>(least, most)(random);
    };
    Rig rig = test::omnimax_rig({side(1, 150), side(1, 150)}, side(20, 200), {side(1, 200), side(1, 200)},
                                kAllNames);
    if (i % 3 == 2) {
      const std::array<FilterSettings, 3> lobed = {robidoux_filter(), jinc_filter(), optimal_filter()};
      rig.filter = lobed[static_cast<std::size_t>(i) / 3 % 3];
    } else {
      rig.filter.radius = std::uniform_real_distribution<>(0.5, 2.5)(random);
      rig.filter.rec = i % 3 == 0 ? 1.0 : 0.0;
    }
    rig.filter.table = i % 2 == 0 ? TableForm::kFast : TableForm::kPrecise;
    const WarpTable table = build_warp_table(rig, pool_);
    for (const test::TexelFunction& texel : {test::noise(static_cast<unsigned>(i)), test::checkerboard(1),
                                             test::TexelFunction([](int, int, int, int) { return 255U; }),
                                             test::TexelFunction([](int, int, int, int) { return 0U; })}) {
      const test::Faces faces = test::make_faces(rig, texel);
      const ImageBuffer expected = warped(table, faces, Cpu::kScalar, pool_);
      const ImageBuffer got = warped(table, faces, GetParam(), pool_);
      ASSERT_TRUE(test::same_pixels(expected.pixels(), got.pixels())) << i;
    }
  }
}

TEST_P(EveryCpu, GivesTheSameBitsForEveryThreadCountAndFormat) {
  Rig rig = test::omnimax_rig({333, 205}, 333, {170, 160}, {"front", "left", "right", "top"});
  WorkerPool one(1);
  WorkerPool five(5);
  const WarpTable table = build_warp_table(rig, one);
  const test::Faces faces = test::make_faces(rig, test::noise(3));
  const ImageBuffer planar = warped(table, faces, GetParam(), one);
  EXPECT_TRUE(test::same_pixels(planar.pixels(), warped(table, faces, GetParam(), five).pixels()));
  for (const PixelFormat format :
       {PixelFormat::kRgb8, PixelFormat::kXrgb8888, PixelFormat::kRgb16, PixelFormat::kRgbPlanar16}) {
    ImageBuffer converted(format, rig.frame.size);
    convert(planar.pixels(), converted.pixels());
    EXPECT_TRUE(test::same_pixels(as_const(converted.pixels()),
                                  warped(table, faces, GetParam(), five, format).pixels()))
        << static_cast<int>(format);
  }
}

TEST_P(EveryCpu, ReadsViewsWithAnyStride) {
  // Faces as parts of an atlas: rows are not contiguous, nothing is aligned.
  Rig rig = test::omnimax_rig({200, 150}, 200, {101, 97}, {"front", "left", "right", "top"});
  const WarpTable table = build_warp_table(rig, pool_);
  const test::Faces apart = test::make_faces(rig, test::noise(4));
  ImageBuffer atlas(PixelFormat::kRgbPlanar8, {101 * 4, 97});
  test::Faces within;
  for (int i = 0; i < 4; ++i) {
    Image face = as_const(atlas.pixels());
    face.size = {101, 97};
    for (int channel = 0; channel < 3; ++channel) {
      face.planes[channel].data += i * 101;
      for (int y = 0; y < 97; ++y) {
        std::copy_n(apart.images[i].samples<std::uint8_t>(channel, y), 101,
                    atlas.pixels().samples<std::uint8_t>(channel, y) + i * 101);
      }
    }
    within.images.push_back(face);
  }
  EXPECT_TRUE(test::same_pixels(warped(table, apart, GetParam(), pool_).pixels(),
                                warped(table, within, GetParam(), pool_).pixels()));
}

INSTANTIATE_TEST_SUITE_P(Kernels, EveryCpu,
                         testing::Values(Cpu::kScalar, Cpu::kSse4, Cpu::kAvx2, Cpu::kAvx512, Cpu::kNeon),
                         [](const auto& instance) { return std::string(name(instance.param)); });

TEST(Kernel, SixteenBitFacesAreWeighedAtFullDepth) {
  WorkerPool pool(2);
  Rig rig = test::omnimax_rig({150, 120}, 150, {90, 80}, {"front", "left", "right", "top"});
  rig.filter.table = TableForm::kPrecise;
  const WarpTable table = build_warp_table(rig, pool);
  const test::Faces eight = test::make_faces(rig, test::noise(6));
  auto same_noise = test::noise(6);
  const test::Faces sixteen = test::make_faces(
      rig, [&](int v, int c, int x, int y) { return same_noise(v, c, x, y) * 257U; },
      PixelFormat::kRgbPlanar16);
  // x * 257 is linear, so that the wide result is the narrow one before rounding, times 257.
  const ImageBuffer narrow = warped(table, eight, Cpu::kScalar, pool);
  const ImageBuffer wide = warped(table, sixteen, Cpu::kScalar, pool, PixelFormat::kRgbPlanar16);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 150; ++x) {
      const int low = narrow.pixels().samples<std::uint8_t>(1, y)[x];
      const int high = wide.pixels().samples<std::uint16_t>(1, y)[x];
      ASSERT_LE(std::abs(high - 257 * low), 129) << x << ' ' << y;
    }
  }
}

}  // namespace
}  // namespace cupola
