// Pictures of 10 bits warped as they come: what 8 bits give where there are no more, near the reference where
// there are, and dithered to what they mean.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/native_warp.h"
#include "pipeline/warp/yuv_rows.h"
#include "tests/warp/yuv_faces.h"

namespace cupola {
namespace {

constexpr YuvColour kFull{YuvMatrix::kBt601, YuvRange::kFull};
constexpr YuvColour kLimited{YuvMatrix::kBt709, YuvRange::kLimited};
const std::vector<std::string> kFour = {"front", "left", "right", "top"};

WorkerPool& pool() {
  static WorkerPool shared(2);
  return shared;
}

unsigned between(std::mt19937& random, unsigned least, unsigned most) {
  return std::uniform_int_distribution<unsigned>(least, most)(random);
}

ImageBuffer warped(const Rig& rig, const test::YuvFaces& faces, Cpu cpu) {
  ImageBuffer frame(PixelFormat::kXrgb8888, rig.frame.size);
  make_native_to_xrgb_warp(rig, faces.images[0].layout, cpu, pool())->warp(faces.images, frame.pixels());
  return frame;
}

// Mean and largest distance of R, G and B from the mean, over the pixels from `from` to `to`.
struct Even {
  double mean[3] = {};
  double most = 0.0;
};
Even evenness(const Image& frame, int from, int to) {
  Even even;
  const auto at = [&](int x, int y, int c) {
    return static_cast<double>(frame.samples<Xrgb>(0, y)[x] >> (16 - 8 * c) & 0xff);
  };
  for (int c = 0; c < 3; ++c) {
    for (int y = from; y < to; ++y) {
      for (int x = from; x < to; ++x) even.mean[c] += at(x, y, c);
    }
    even.mean[c] /= (to - from) * (to - from);
    for (int y = from; y < to; ++y) {
      for (int x = from; x < to; ++x) even.most = std::max(even.most, std::abs(at(x, y, c) - even.mean[c]));
    }
  }
  return even;
}

TEST(P010Warp, OfWhat8BitsCanSayGivesToTheBitTheFrameOfNv12) {
  for (const auto& kernel : {Kernel::kGaussian, Kernel::kOptimal}) {
    Rig rig = test::omnimax_rig({200, 146}, 200, {122, 97}, kFour);
    rig.filter.kernel = kernel;
    rig.filter.table = TableForm::kPrecise;
    rig.samples.dither = false;
    const test::YuvFaces nv12 = test::make_yuv_faces(rig, NativeLayout::kNv12, kLimited, test::noise(3));
    const test::YuvFaces p010 = test::make_yuv_faces(
        rig, NativeLayout::kP010, kLimited, [texel = test::noise(3)](int view, int channel, int x, int y) {
          return 4 * texel(view, channel, x, y);
        });
    // Sums of 8 bits are clamped half a step above 255, those of more bits farther up.
    const ImageBuffer expected = warped(rig, nv12, Cpu::kScalar);
    if (kernel == Kernel::kGaussian) {
      EXPECT_TRUE(test::same_pixels(expected.pixels(), as_const(warped(rig, p010, best_cpu()).pixels())));
    }
    rig.filter.table = TableForm::kFast;  // is precise all the same
    EXPECT_TRUE(test::same_pixels(as_const(warped(rig, p010, Cpu::kScalar).pixels()),
                                  as_const(warped(rig, p010, best_cpu()).pixels())));
  }
}

TEST(P010Warp, EveryKernelGivesTheScalarBitsOverRandomRigsAndSizes) {
  std::mt19937 random(19);
  for (int i = 0; i < 12; ++i) {
    const auto side = [&](int least, int most) {
      return std::uniform_int_distribution<>(least, most)(random);
    };
    Rig rig =
        test::omnimax_rig({side(1, 150), side(1, 150)}, side(20, 200), {side(1, 120), side(1, 120)}, kFour);
    rig.filter.radius = std::uniform_real_distribution<>(0.5, 2.5)(random);
    rig.samples.dither = i % 2 == 0;
    const YuvColour colour = i % 4 < 2 ? kLimited : kFull;
    for (const test::TexelFunction& texel :
         {test::noise(static_cast<unsigned>(i), 1023),
          test::TexelFunction([](int, int, int x, int y) { return (x + y) % 2 == 0 ? 1023U : 0U; }),
          test::TexelFunction([](int, int, int, int) { return 1023U; })}) {
      const test::YuvFaces faces = test::make_yuv_faces(rig, NativeLayout::kP010, colour, texel);
      const ImageBuffer expected = warped(rig, faces, Cpu::kScalar);
      for (const Cpu cpu : {Cpu::kSse4, Cpu::kAvx2, Cpu::kAvx512, Cpu::kNeon}) {
        if (!supported(cpu)) continue;
        ASSERT_TRUE(test::same_pixels(expected.pixels(), as_const(warped(rig, faces, cpu).pixels())))
            << i << ' ' << name(cpu);
      }
    }
  }
}

TEST(P010Warp, StaysWithinItsBoundOfTheReference) {
  Rig rig = test::omnimax_rig({600, 438}, 600, {312, 312}, kFour);
  rig.samples.dither = false;
  const auto smooth = [](const Vec3& d) {
    return Vec3{126.0 + 30.0 * std::sin(9.0 * d.x + 4.0 * d.y),
                128.0 + 22.0 * std::sin(6.0 * d.y - 3.0 * d.z),
                128.0 + 22.0 * std::cos(7.0 * d.x + 2.0 * d.z)};
  };
  for (const YuvColour colour : {kLimited, kFull}) {
    const test::YuvFaces faces = test::make_yuv_faces(rig, NativeLayout::kP010, colour, smooth, 35);
    std::vector<double> exact = ewa_exact_frame(rig, test::shown(rig, faces).images, pool());
    for (double& sample : exact) sample /= 257.0;
    const ImageBuffer frame = warped(rig, faces, best_cpu());
    ImageBuffer planar(PixelFormat::kRgbPlanar8, rig.frame.size);
    convert(frame.pixels(), planar.pixels());
    const test::Difference d = test::difference(rig, as_const(planar.pixels()), exact);
    std::printf("10 bits: rms %.3f, max %.2f LSB\n", d.rms, d.max);
    EXPECT_LE(d.rms, 0.31);
    EXPECT_LE(d.max, 1.1) << d.x << ' ' << d.y;
  }
}

TEST(P010Warp, DithersToTheMeanOfWhatItShowsAndKeepsBlackAndWhite) {
  const Rig rig = test::omnimax_rig({200, 200}, 200, {100, 100}, kFour);
  std::mt19937 random(4);
  for (const YuvColour colour : {kLimited, kFull}) {
    const double white = 255.75;
    for (int i = 0; i < 12; ++i) {
      const std::array<unsigned, 3> yuv{between(random, 400, 599), between(random, 470, 549),
                                        between(random, 470, 549)};
      const test::YuvFaces faces = test::make_yuv_faces(
          rig, NativeLayout::kP010, colour,
          [&](int, int channel, int, int) { return yuv[static_cast<std::size_t>(channel)]; });
      const ImageBuffer frame = warped(rig, faces, best_cpu());
      const Even even = evenness(frame.pixels(), 68, 132);
      const Vec3 real = test::rgb_of(colour, {yuv[0] / 4.0, yuv[1] / 4.0, yuv[2] / 4.0}, white);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(even.mean[c], real[c], 0.05 + 0.031) << c;
      EXPECT_LE(even.most, 1.0);
    }
    for (const bool bright : {false, true}) {
      const unsigned luma = colour.range == YuvRange::kFull ? (bright ? 1023U : 0U) : (bright ? 940U : 64U);
      const test::YuvFaces faces =
          test::make_yuv_faces(rig, NativeLayout::kP010, colour,
                               [&](int, int channel, int, int) { return channel == 0 ? luma : 512U; });
      const ImageBuffer frame = warped(rig, faces, best_cpu());
      const Even even = evenness(frame.pixels(), 68, 132);
      EXPECT_EQ(even.mean[0], bright ? 255.0 : 0.0);
      EXPECT_EQ(even.most, 0.0);
    }
  }
}

// A slope of a step in some 30 pixels: rounding makes stairs of it, dithering does not.
TEST(P010Warp, ShowsSlopesThat8BitsCannot) {
  Rig rig = test::omnimax_rig({400, 400}, 400, {200, 200}, kFour);
  const auto slope = [](const Vec3& d) { return Vec3{100.0 + 4.0 * d.x, 128.0, 128.0}; };
  const test::YuvFaces faces = test::make_yuv_faces(rig, NativeLayout::kP010, kFull, slope);
  std::vector<double> exact = ewa_exact_frame(rig, test::shown(rig, faces).images, pool());
  for (double& sample : exact) sample /= 257.0;
  const auto worst_mean = [&](bool dither) {
    rig.samples.dither = dither;
    const ImageBuffer frame = warped(rig, faces, best_cpu());
    double worst = 0.0;
    for (int top = 100; top < 300; top += 10) {
      for (int left = 100; left < 300; left += 10) {
        double sum = 0.0;
        for (int y = top; y < top + 10; ++y) {
          for (int x = left; x < left + 10; ++x) {
            const auto at = static_cast<std::size_t>(y * 400 + x);
            sum += (frame.pixels().samples<Xrgb>(0, y)[x] & 0xff) - exact[3 * at + 2];
          }
        }
        worst = std::max(worst, std::abs(sum / 100.0));
      }
    }
    return worst;
  };
  const double rounded = worst_mean(false);
  const double dithered = worst_mean(true);
  std::printf("means of 10 x 10 pixels err by up to %.3f rounded, %.3f dithered\n", rounded, dithered);
  EXPECT_GT(rounded, 0.4);
  EXPECT_LT(dithered, 0.1);
}

TEST(P010Warp, MakesNoFramesOfNv12) {
  const Rig rig = test::omnimax_rig({200, 146}, 200, {64, 64}, kFour);
  EXPECT_ANY_THROW(make_nv12_warp(rig, NativeLayout::kP010, best_cpu(), pool()));
}

TEST(P010Rows, EveryKernelDithersToTheScalarBitsAtAnyPlace) {
  std::mt19937 random(2);
  const auto fine = [&] {
    const unsigned kind = between(random, 0, 9);
    return static_cast<std::uint16_t>(kind == 0   ? kMostWideFine
                                      : kind == 1 ? 0
                                                  : random() % (kMostWideFine + 1));
  };
  for (const Cpu cpu : {Cpu::kSse4, Cpu::kAvx2, Cpu::kAvx512, Cpu::kNeon}) {
    if (!supported(cpu)) continue;
    for (int i = 0; i < 1000; ++i) {
      std::vector<Luma> luma(100);
      std::vector<Chroma> chroma(100);
      for (Luma& y : luma) y = random() % 10 == 0 ? kNoFine : fine();
      for (Chroma& uv : chroma) uv = random() % 10 == 0 ? kBlack<Chroma> : Chroma{fine(), fine()};
      const int count = static_cast<int>(random() % 101);
      const int x = static_cast<int>(random() % 16384);
      const int y = static_cast<int>(random() % 16384);
      const YuvToRgb matrix = yuv_to_rgb(i % 2 == 0 ? kFull : kLimited, {}, 10);
      std::vector<Xrgb> expected(100), got(100);
      kYuvRowsScalar.xrgb_dithered(luma.data(), chroma.data(), count, matrix, x, y, expected.data());
      yuv_rows(cpu).xrgb_dithered(luma.data(), chroma.data(), count, matrix, x, y, got.data());
      ASSERT_EQ(expected, got);
    }
  }
}

}  // namespace
}  // namespace cupola
