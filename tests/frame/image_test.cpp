// Buffers and conversion between pixel formats.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

constexpr PixelFormat kFormats[] = {PixelFormat::kRgbPlanar8, PixelFormat::kRgbPlanar16, PixelFormat::kRgb8,
                                    PixelFormat::kRgb16, PixelFormat::kXrgb8888};

TEST(ImageBuffer, IsZeroAndItsRowsBeginOn64ByteBoundaries) {
  for (const PixelFormat format : kFormats) {
    ImageBuffer image(format, {33, 5});
    for (std::size_t p = 0; p < static_cast<std::size_t>(plane_count(format)); ++p) {
      for (int y = 0; y < 5; ++y) {
        const std::byte* row = image.pixels().planes[p].row(y);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(row) % 64, 0U);
        for (int i = 0; i < 33 * pixel_step(format); ++i) EXPECT_EQ(row[i], std::byte{0});
      }
    }
  }
}

TEST(ImageBuffer, HasSlackOf64BytesAfterTheLastRow) {
  ImageBuffer image(PixelFormat::kRgb8, {64, 3});
  const Plane<std::byte>& plane = image.pixels().planes[0];
  EXPECT_GE(image.bytes(), static_cast<std::size_t>(plane.stride * 3 + 64));
  std::memset(plane.row(2) + 64 * 3, 1, 64);  // the address sanitizer would object
}

TEST(ImageBuffer, KeepsItsPixelsWhenItIsMoved) {
  ImageBuffer image = noise_picture(PixelFormat::kRgb8, {4, 4});
  const int before = sample(image, 1, 2, 3);
  const ImageBuffer moved = std::move(image);
  EXPECT_EQ(sample(moved, 1, 2, 3), before);
}

TEST(Convert, LosesNothingBetweenFormatsOfEqualDepth) {
  for (const PixelFormat from : kFormats) {
    const ImageBuffer source = noise_picture(from, {37, 9});
    for (const PixelFormat to : kFormats) {
      if (sample_bytes(from) != sample_bytes(to)) continue;
      ImageBuffer target(to, source.size());
      convert(source.pixels(), target.pixels());
      EXPECT_EQ(largest_difference(source.pixels(), target.pixels()), 0);
    }
  }
}

TEST(Convert, WidensEveryByteTo257TimesItself) {
  ImageBuffer narrow(PixelFormat::kRgbPlanar8, {256, 1});
  for (int x = 0; x < 256; ++x) narrow.pixels().samples<std::uint8_t>(1, 0)[x] = static_cast<std::uint8_t>(x);
  for (const PixelFormat format : {PixelFormat::kRgbPlanar16, PixelFormat::kRgb16}) {
    ImageBuffer wide(format, narrow.size());
    convert(narrow.pixels(), wide.pixels());
    for (int x = 0; x < 256; ++x) EXPECT_EQ(sample(wide, 1, x, 0), 257 * x);
  }
}

TEST(Convert, RoundsEverySixteenBitValueToTheNearestByte) {
  ImageBuffer wide(PixelFormat::kRgbPlanar16, {65'535, 2});
  for (int v = 0; v < 65'536; ++v)
    wide.pixels().samples<std::uint16_t>(0, v / 65'535)[v % 65'535] = static_cast<std::uint16_t>(v);
  ImageBuffer narrow(PixelFormat::kRgbPlanar8, wide.size());
  convert(wide.pixels(), narrow.pixels());
  for (int v = 0; v < 65'536; ++v)
    ASSERT_EQ(as_const(narrow.pixels()).samples<std::uint8_t>(0, v / 65'535)[v % 65'535],
              std::lround(v / 257.0))
        << v;
}

TEST(Convert, WritesWindowWordsAsBlueGreenRedAndFullyOpaque) {
  ImageBuffer source(PixelFormat::kRgb8, {1, 1});
  auto* rgb = source.pixels().samples<std::uint8_t>(0, 0);
  rgb[0] = 0x11, rgb[1] = 0x22, rgb[2] = 0x33;
  ImageBuffer target(PixelFormat::kXrgb8888, {1, 1});
  convert(source.pixels(), target.pixels());
  const auto* bytes = as_const(target.pixels()).samples<std::uint8_t>(0, 0);
  EXPECT_EQ(bytes[0], 0x33);
  EXPECT_EQ(bytes[1], 0x22);
  EXPECT_EQ(bytes[2], 0x11);
  EXPECT_EQ(bytes[3], 0xff);
}

TEST(PartOf, IsTheSamePixelsWithoutACopy) {
  for (const PixelFormat format : kFormats) {
    const ImageBuffer image = noise_picture(format, {20, 12});
    const Image part = part_of(image.pixels(), 5, 7, {6, 3});
    EXPECT_EQ(part.size, (Size{6, 3}));
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 6; ++x)
        for (int c = 0; c < 3; ++c) EXPECT_EQ(sample(part, c, x, y), sample(image, c, x + 5, y + 7));
  }
}

}  // namespace
}  // namespace cupola
