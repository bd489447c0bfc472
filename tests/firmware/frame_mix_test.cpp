// Mixing two frames, against the same in double precision.
// SPDX-License-Identifier: MIT
#include "firmware/frame_mix.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

template <class Sample>
void expect_as_in_double(int most) {
  // Every pair of interesting values: ends, middles, and all differences of small ones.
  std::vector<Sample> values;
  for (int i = 0; i < 24; ++i) {
    values.push_back(static_cast<Sample>(i));
    values.push_back(static_cast<Sample>(most - i));
    values.push_back(static_cast<Sample>(most / 2 - 12 + i));
  }
  const int side = static_cast<int>(values.size());
  const PixelFormat format = sizeof(Sample) == 2 ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8;
  ImageBuffer a(format, {side, side});
  ImageBuffer b(format, {side, side});
  ImageBuffer mixed(format, {side, side});
  for (int p = 0; p < 3; ++p) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        a.pixels().samples<Sample>(p, y)[x] = values[static_cast<std::size_t>(y)];
        b.pixels().samples<Sample>(p, y)[x] = values[static_cast<std::size_t>(x)];
      }
    }
  }
  WorkerPool pool(2);
  for (std::int32_t weight = 0; weight <= kWholeWeight; weight += weight < 64 ? 1 : 509) {
    mix(as_const(a.pixels()), as_const(b.pixels()), weight, mixed.pixels(), pool);
    const double share = static_cast<double>(weight) / kWholeWeight;
    for (int p = 0; p < 3; ++p) {
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
          const double exact = (1.0 - share) * values[static_cast<std::size_t>(y)] +
                               share * values[static_cast<std::size_t>(x)];
          ASSERT_EQ(mixed.pixels().samples<Sample>(p, y)[x], std::floor(exact + 0.5))
              << weight << ": " << values[static_cast<std::size_t>(y)] << " and "
              << values[static_cast<std::size_t>(x)];
        }
      }
    }
  }
  mix(as_const(a.pixels()), as_const(b.pixels()), kWholeWeight, mixed.pixels(), pool);
  EXPECT_EQ(mixed.pixels().samples<Sample>(0, 3)[5], values[5]) << "the whole weight is the new frame";
}

TEST(FrameMix, IsTheRoundedMeanOfEightBits) {
  expect_as_in_double<std::uint8_t>(255);
}
TEST(FrameMix, IsTheRoundedMeanOfSixteenBits) {
  expect_as_in_double<std::uint16_t>(65535);
}

TEST(FrameMix, DimsAsItMixesWithBlack) {
  WorkerPool pool(2);
  const ImageBuffer picture = noise_picture(PixelFormat::kXrgb8888, {61, 35}, 3);
  ImageBuffer black(PixelFormat::kXrgb8888, {61, 35});
  blacken(black.pixels());
  ImageBuffer mixed(PixelFormat::kXrgb8888, {61, 35});
  ImageBuffer dimmed(PixelFormat::kXrgb8888, {61, 35});
  for (const std::int32_t weight : {0, 1, 77, 16384, 32767, 32768}) {
    mix(as_const(black.pixels()), picture.pixels(), weight, mixed.pixels(), pool);
    dim(picture.pixels(), weight, dimmed.pixels(), pool);
    for (int y = 0; y < 35; ++y) {
      for (int x = 0; x < 61; ++x) {
        ASSERT_EQ(dimmed.pixels().samples<std::uint32_t>(0, y)[x],
                  mixed.pixels().samples<std::uint32_t>(0, y)[x] | 0xff000000U);
      }
    }
  }
}

TEST(FrameMix, IsTheSameForEveryFormatWidthAndThread) {
  for (const Size size : {Size{1, 1}, Size{37, 33}, Size{64, 16}}) {
    for (const PixelFormat format : {PixelFormat::kRgb8, PixelFormat::kXrgb8888, PixelFormat::kRgb16}) {
      const ImageBuffer a = noise_picture(format, size, 1);
      const ImageBuffer b = noise_picture(format, size, 2);
      ImageBuffer first(format, size);
      ImageBuffer second(format, size);
      WorkerPool alone(1);
      WorkerPool three(3);
      mix(a.pixels(), b.pixels(), 12345, first.pixels(), alone);
      mix(a.pixels(), b.pixels(), 12345, second.pixels(), three);
      for (int y = 0; y < size.height; ++y) {
        EXPECT_EQ(std::memcmp(first.pixels().planes[0].row(y), second.pixels().planes[0].row(y),
                              static_cast<std::size_t>(size.width * pixel_step(format))),
                  0);
      }
      blacken(first.pixels());
      const std::byte last =
          first.pixels().planes[0].row(size.height - 1)[size.width * pixel_step(format) - 1];
      EXPECT_EQ(last, format == PixelFormat::kXrgb8888 ? std::byte{255} : std::byte{0});
    }
  }
}

}  // namespace
}  // namespace cupola
