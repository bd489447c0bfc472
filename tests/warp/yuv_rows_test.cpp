// Rows of luma and chroma on their way out: the matrix, and every kernel against the scalar one.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/yuv_rows.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/warp/yuv_faces.h"

namespace cupola {
namespace {

constexpr YuvColour kColours[] = {{YuvMatrix::kBt601, YuvRange::kLimited},
                                  {YuvMatrix::kBt601, YuvRange::kFull},
                                  {YuvMatrix::kBt709, YuvRange::kLimited},
                                  {YuvMatrix::kBt709, YuvRange::kFull}};

// Often at the ends of what there may be.
ViewColour any_colour(std::mt19937& random) {
  const auto between = [&](double least, double most) {
    const int kind = std::uniform_int_distribution<>(0, 5)(random);
    return kind == 0 ? least : kind == 1 ? most : std::uniform_real_distribution<>(least, most)(random);
  };
  ViewColour colour;
  for (std::size_t c = 0; c < 3; ++c) {
    colour.gain[c] = between(ViewColour::kLeastGain, ViewColour::kMostGain);
    colour.offset[c] = between(-ViewColour::kMostOffset, ViewColour::kMostOffset);
  }
  return colour;
}

TEST(YuvRows, ColoursErrByLessThanTheStatedPartOfAStep) {
  std::mt19937 random(1);
  std::uniform_int_distribution<> sample(0, 255);
  for (const YuvColour colour : kColours) {
    const YuvToRgb matrix = yuv_to_rgb(colour);
    for (int i = 0; i < 200'000; ++i) {
      const int y = sample(random);
      const int u = sample(random);
      const int v = sample(random);
      const auto luma = static_cast<Luma>(y * 64);
      const Chroma chroma{static_cast<std::uint16_t>(u * 64), static_cast<std::uint16_t>(v * 64)};
      Xrgb got = 0;
      kYuvRowsScalar.xrgb(&luma, &chroma, 1, matrix, &got);
      const Vec3 real = test::rgb_of(colour, {y, u, v});
      for (int channel = 0; channel < 3; ++channel) {
        const int value = static_cast<int>(got >> (16 - 8 * channel) & 0xff);
        ASSERT_NEAR(value, std::clamp(real[channel], 0.0, 255.0), 0.5 + 0.031) << y << ' ' << u << ' ' << v;
      }
      ASSERT_EQ(got >> 24, 0xffU);
    }
  }
}

TEST(YuvRows, GainsAndOffsetsErrNoMoreThanTheirCoefficients) {
  std::mt19937 random(5);
  std::uniform_int_distribution<> sample(0, 255);
  for (int i = 0; i < 200'000; ++i) {
    const YuvColour colour = kColours[i % 4];
    const ViewColour view = any_colour(random);
    const YuvToRgb matrix = yuv_to_rgb(colour, view);
    const int y = sample(random);
    const int u = sample(random);
    const int v = sample(random);
    const auto luma = static_cast<Luma>(y * 64);
    const Chroma chroma{static_cast<std::uint16_t>(u * 64), static_cast<std::uint16_t>(v * 64)};
    Xrgb got = 0;
    kYuvRowsScalar.xrgb(&luma, &chroma, 1, matrix, &got);
    const Vec3 real = test::rgb_of(colour, {y, u, v});
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const int value = static_cast<int>(got >> (16 - 8 * channel) & 0xff);
      const double wanted = view.of(channel, real[static_cast<int>(channel)]);
      ASSERT_NEAR(value, std::clamp(wanted, 0.0, 255.0), 0.5 + 0.031) << y << ' ' << u << ' ' << v;
    }
  }
}

TEST(YuvRows, GreyStaysGrey) {
  for (const YuvColour colour : kColours) {
    const YuvToRgb matrix = yuv_to_rgb(colour);
    for (int fine = 0; fine <= kMostFine; ++fine) {
      const auto luma = static_cast<Luma>(fine);
      const Chroma grey{128 * 64, 128 * 64};
      Xrgb got = 0;
      kYuvRowsScalar.xrgb(&luma, &grey, 1, matrix, &got);
      ASSERT_EQ(got & 0xff, got >> 8 & 0xff);
      ASSERT_EQ(got & 0xff, got >> 16 & 0xff);
    }
  }
}

TEST(YuvRows, EveryKernelGivesTheScalarBitsForAnyLengthAndAlignment) {
  std::mt19937 random(2);
  std::uniform_int_distribution<> sample(0, kMostFine);
  std::uniform_int_distribution<> which(0, 9);
  constexpr int kMost = 300;
  const auto fine = [&] {
    const int kind = which(random);
    return static_cast<std::uint16_t>(kind == 0 ? kMostFine : kind == 1 ? 0 : sample(random));
  };
  for (const Cpu cpu : {Cpu::kSse4, Cpu::kAvx2, Cpu::kAvx512, Cpu::kNeon}) {
    if (!supported(cpu)) continue;
    const YuvRows& rows = yuv_rows(cpu);
    for (int i = 0; i < 3000; ++i) {
      std::vector<Luma> luma(kMost);
      std::vector<Chroma> chroma(kMost);
      for (Luma& y : luma) y = which(random) == 0 ? kNoFine : fine();
      for (Chroma& uv : chroma) uv = which(random) == 0 ? kBlack<Chroma> : Chroma{fine(), fine()};
      const int first = std::uniform_int_distribution<>(0, 64)(random);
      const int count = std::uniform_int_distribution<>(0, kMost - first)(random);
      const int at = std::uniform_int_distribution<>(0, 64)(random);
      const YuvToRgb matrix = yuv_to_rgb(kColours[i % 4], any_colour(random));
      std::vector<std::uint8_t> y1(500, 0xa5), y2(500, 0xa5), uv1(900, 0xa5), uv2(900, 0xa5);
      std::vector<Xrgb> out1(500, 0xa5), out2(500, 0xa5);
      kYuvRowsScalar.luma(&luma[first], count, 16, &y1[at]);
      rows.luma(&luma[first], count, 16, &y2[at]);
      kYuvRowsScalar.chroma(&chroma[first], count, &uv1[at]);
      rows.chroma(&chroma[first], count, &uv2[at]);
      kYuvRowsScalar.xrgb(&luma[first], &chroma[first], count, matrix, &out1[at]);
      rows.xrgb(&luma[first], &chroma[first], count, matrix, &out2[at]);
      ASSERT_EQ(y1, y2);
      ASSERT_EQ(uv1, uv2);
      ASSERT_EQ(out1, out2);
    }
  }
}

}  // namespace
}  // namespace cupola
