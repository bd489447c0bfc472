// Rows of 16 bits a sample on their way into frames of 8: rounded, dithered, or from light to sRGB.
//
// A sample is 257 a + b with 0 <= b < 257. It becomes (257 a + b + s) / 257, rounded down, for a threshold s
// in [0, 256]: 128 rounds to nearest; thresholds that take all 257 values equally often give a + 1 in b of
// 257 places, so that the mean is the sample's own. Multiples of 257, which are what 8 bits become in 16,
// stay what they are under every threshold.
//
// The thresholds are a function of the pixel's place in the frame alone: t = x / g + y / g^2, mod 1, for the
// real root g of g^3 = g + 1 (Roberts' R2 sequence), folded to a triangle: neighbours differ much, any patch
// of a few pixels has them all about evenly, and there is no seam. In units of 2^-32 t wraps by itself.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "pipeline/warp/tile_kernel.h"

namespace cupola {

inline constexpr std::uint32_t kDitherX = 3242174889;  // 2^32 / g
inline constexpr std::uint32_t kDitherY = 2447445414;  // 2^32 / g^2

// The triangle, 0 to 2^31 - 1.
constexpr std::uint32_t dither_triangle(int x, int y) {
  const std::uint32_t t = static_cast<std::uint32_t>(x) * kDitherX + static_cast<std::uint32_t>(y) * kDitherY;
  return t >> 31 != 0 ? ~t : t;
}

constexpr unsigned dither_threshold(int x, int y) {
  return (dither_triangle(x, y) >> 15) * 257 >> 16;
}

constexpr std::uint8_t narrowed(unsigned sample, unsigned threshold) {
  const unsigned sum = sample + threshold;
  return static_cast<std::uint8_t>((sum < 65535 ? sum : 65535) / 257);
}

// `count` pixels that go to (x, y) and on to the right.
using NarrowRow = void (*)(const Rgb16* from, int count, int x, int y, Xrgb* to) noexcept;
void narrow_rounded_scalar(const Rgb16* from, int count, int x, int y, Xrgb* to) noexcept;
void narrow_rounded_sse4(const Rgb16* from, int count, int x, int y, Xrgb* to) noexcept;
void narrow_dithered_scalar(const Rgb16* from, int count, int x, int y, Xrgb* to) noexcept;
void narrow_dithered_sse4(const Rgb16* from, int count, int x, int y, Xrgb* to) noexcept;
// From light, by a table: the same on every machine. The second goes by sRGB of 16 bits.
void narrow_light(const Rgb16* from, int count, int x, int y, Xrgb* to) noexcept;
void narrow_light_dithered(const Rgb16* from, int count, int x, int y, Xrgb* to) noexcept;

}  // namespace cupola
