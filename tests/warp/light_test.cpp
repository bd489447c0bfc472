// Filtering in linear light, and 16 bits that become 8.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "pipeline/frame/srgb_curve.h"
#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/light.h"
#include "pipeline/warp/narrow_rows.h"
#include "pipeline/warp/table_build.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

constexpr SampleSettings kLinear{.linear_light = true};
const std::vector<std::string> kFour = {"front", "left", "right", "top"};

Rig linear_rig(Size frame, Size face) {
  Rig rig = test::omnimax_rig(frame, frame.width, face, kFour);
  rig.samples = kLinear;
  rig.filter.table = TableForm::kPrecise;
  return rig;
}

TEST(Light, IsTheCurveOfTheStandardAndItsInverse) {
  EXPECT_NEAR(light_of_srgb(0.5), 0.21404114048223255, 1e-14);
  EXPECT_NEAR(light_of_srgb(0.04), 0.04 / 12.92, 1e-16);
  EXPECT_DOUBLE_EQ(light_of_srgb(1.0), 1.0);
  for (int i = 0; i <= 1000; ++i) EXPECT_NEAR(srgb_of_light(light_of_srgb(i / 1000.0)), i / 1000.0, 1e-7);
}

TEST(Light, EightBitsOfSrgbGoThereAndBackUnchanged) {
  for (unsigned i = 0; i < 256; ++i) {
    const std::uint16_t light = kLightOfSrgb8.words[i];
    EXPECT_EQ(light_tables().srgb8_of_light[light], i);
    EXPECT_EQ(kLightOfSrgb8.low[i] | kLightOfSrgb8.high[i] << 8, light);
  }
}

TEST(Light, SixteenBitsOfSrgbLoseAtMostSevenOfTheirSteps) {
  int most = 0;
  for (int i = 0; i < 65536; ++i) {
    const int back = light_tables().srgb16_of_light[light_tables().light_of_srgb16[static_cast<unsigned>(i)]];
    most = std::max(most, std::abs(back - i));
  }
  EXPECT_LE(most, 7);
}

TEST(Light, EveryEvenFaceComesOutUnchanged) {
  WorkerPool pool(2);
  for (const FilterSettings& filter : {default_gaussian(), optimal_filter()}) {
    Rig rig = linear_rig({70, 51}, {40, 40});
    rig.filter = filter;
    const WarpTable table = build_warp_table(rig, pool);
    const auto warp = make_table_warp(table, best_cpu(), pool, kLinear);
    ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
    for (unsigned value = 0; value < 256; ++value) {
      const test::Faces faces = test::make_faces(rig, [&](int, int, int, int) { return value; });
      warp->warp(faces.images, frame.pixels());
      const Image got = as_const(frame.pixels());
      ASSERT_EQ(got.samples<std::uint8_t>(0, 30)[35], value);
      for (int y = 0; y < rig.frame.size.height; ++y) {
        for (int x = 0; x < rig.frame.size.width; ++x) {
          const unsigned pixel = got.samples<std::uint8_t>(1, y)[x];
          ASSERT_TRUE(pixel == value || pixel == 0) << value << " at " << x << ' ' << y;
        }
      }
    }
  }
}

// Black beside white is where linear light differs most, and where errors of weights show most.
TEST(Light, IsWithinOneStepOfTheFormulasWherePicturesAreDarkAndBright) {
  WorkerPool pool(2);
  for (const FilterSettings& filter :
       {default_gaussian(), paper_preset(), robidoux_filter(), optimal_filter()}) {
    for (const int face : {60, 130}) {
      Rig rig = linear_rig({120, 90}, {face, face});
      rig.filter = filter;
      rig.filter.table = TableForm::kPrecise;
      const WarpTable table = build_warp_table(rig, pool);
      const auto warp = make_table_warp(table, best_cpu(), pool, kLinear);
      const auto some_noise = test::noise(5);
      for (const test::TexelFunction& texel :
           {test::noise(3), test::checkerboard(1), test::checkerboard(5), test::noise(4, 12),
            test::TexelFunction(
                [&](int v, int c, int x, int y) { return 243 + some_noise(v, c, x, y) / 22; }),
            test::TexelFunction(
                [](int, int, int x, int y) { return x % 7 == 0 && y % 7 == 0 ? 255U : 0U; })}) {
        const test::Faces faces = test::make_faces(rig, texel);
        ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
        warp->warp(faces.images, frame.pixels());
        std::vector<double> exact = ewa_exact_frame(rig, faces.images, pool);
        // What no display can show is cut off before it is compared.
        for (double& value : exact) value = std::clamp(value, 0.0, 255.0);
        const test::Difference found = test::difference(rig, as_const(frame.pixels()), exact);
        // With negative lobes bright texels cancel out to dark pixels, and what their weights err by remains.
        const double bound = filter.kernel == Kernel::kOptimal ? 4.0 : 1.0;
        EXPECT_LE(found.max, bound) << "at " << found.x << ' ' << found.y << ", faces of " << face
                                    << ", kernel " << static_cast<int>(filter.kernel) << ", rms "
                                    << found.rms;
      }
    }
  }
}

TEST(Light, FacesOf16BitsAreWeighedAsLightToo) {
  WorkerPool pool(2);
  const Rig rig = linear_rig({120, 90}, {90, 90});
  const WarpTable table = build_warp_table(rig, pool);
  const test::Faces faces = test::make_faces(rig, test::noise(6, 65535), PixelFormat::kRgbPlanar16);
  const std::vector<double> exact = ewa_exact_frame(rig, faces.images, pool);
  for (const Cpu cpu : {Cpu::kScalar, best_cpu()}) {
    ImageBuffer frame(PixelFormat::kRgbPlanar16, rig.frame.size);
    make_table_warp(table, cpu, pool, kLinear)->warp(faces.images, frame.pixels());
    const test::Difference found = test::difference(rig, as_const(frame.pixels()), exact);
    EXPECT_LE(found.max, 64.0) << "steps of 16 bits, at " << found.x << ' ' << found.y;
  }
}

// The same for faces of 16 bits that become 8: rounded to nearest where nothing dithers.
TEST(Dither, GivesTheRoundedFrameWhereItIsTurnedOff) {
  WorkerPool pool(2);
  Rig rig = linear_rig({90, 70}, {60, 60});
  const WarpTable table = build_warp_table(rig, pool);
  const test::Faces faces = test::make_faces(rig, test::noise(6, 65535), PixelFormat::kRgbPlanar16);
  ImageBuffer deep(PixelFormat::kRgbPlanar16, rig.frame.size);
  ImageBuffer rounded(PixelFormat::kRgb8, rig.frame.size);
  ImageBuffer dithered(PixelFormat::kRgb8, rig.frame.size);
  ImageBuffer expected(PixelFormat::kRgb8, rig.frame.size);
  const SampleSettings plain{.dither = false};
  make_table_warp(table, best_cpu(), pool, plain)->warp(faces.images, deep.pixels());
  make_table_warp(table, best_cpu(), pool, plain)->warp(faces.images, rounded.pixels());
  make_table_warp(table, best_cpu(), pool)->warp(faces.images, dithered.pixels());
  convert(as_const(deep.pixels()), expected.pixels());
  EXPECT_TRUE(test::same_pixels(as_const(expected.pixels()), as_const(rounded.pixels())));
  EXPECT_FALSE(test::same_pixels(as_const(dithered.pixels()), as_const(rounded.pixels())));
}

std::vector<Rgb16> row_of_grey(int count, std::uint16_t value) {
  return std::vector<Rgb16>(static_cast<std::size_t>(count), Rgb16{value, value, value, 0});
}

TEST(Dither, HasTheMeanOfWhatItNarrowsInEveryPatch) {
  constexpr int kSide = 16;
  for (int value = 0; value < 65536; value += 37) {
    double sum = 0.0;
    for (int y = 0; y < kSide; ++y) {
      std::vector<Xrgb> out(kSide);
      narrow_dithered_scalar(row_of_grey(kSide, static_cast<std::uint16_t>(value)).data(), kSide, 300,
                             500 + y, out.data());
      for (const Xrgb pixel : out) {
        const int got = pixel & 0xff;
        ASSERT_LT(std::abs(got - value / 257.0), 1.0);
        sum += got;
      }
    }
    EXPECT_NEAR(sum / (kSide * kSide), value / 257.0, 0.03) << value;
  }
}

TEST(Dither, IsUnbiasedOverAGradient) {
  constexpr int kWidth = 2048;
  double off = 0.0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const unsigned value = 20000 + static_cast<unsigned>(x);  // 8 steps of 8 bits
      off += narrowed(value, dither_threshold(x, y)) - value / 257.0;
    }
  }
  EXPECT_NEAR(off / (64.0 * kWidth), 0.0, 0.001);
}

TEST(Dither, LeavesWhatEightBitsCanSay) {
  for (unsigned value = 0; value < 256; ++value) {
    for (int at = 0; at < 100; ++at) {
      EXPECT_EQ(narrowed(value * 257, dither_threshold(7 * at, at)), value);
    }
  }
}

}  // namespace
}  // namespace cupola
