// Rows of warped luma and chroma on their way out: into the planes of NV12, or converted into XRGB8888.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "pipeline/frame/native_image.h"
#include "pipeline/warp/cpu.h"
#include "pipeline/warp/narrow_rows.h"
#include "pipeline/warp/tile_kernel.h"
#include "pipeline/warp/view_colour.h"

namespace cupola {

// R, G, B = (y Y + (u, v) . (U, V) + start) >> kShift, each with its own numbers, clamped to 0 to 255,
// of samples with kFineBits fractional bits. Coefficients are the matrix's times 2^kCoefficientBits, rounded:
// each errs by at most 2^-14, which makes less than 0.031 of an 8-bit step over 239 steps of Y and 128 of U
// and V.
//
// Ranges. Samples are at most 16,383 < 2^14. |Coefficients| are at most 17,305, times a gain of up to 1.8
// 31,149: both fit 16 bits with sign. Of luma that makes up to 9,539 1.8 16,383 < 2.9e8, of chroma, which has
// at most two terms of different signs or lesser ones of the same, less than 5.2e8; start, with an offset of
// up to 64 steps of 2^19, is below 3.2e8 in magnitude: all partial sums stay within 1.2e9 < 2^31.
//
// Dithered, a pixel has a threshold of its own (narrow_rows.h) in place of the half step, from
// kLeastThreshold to as much below a step: colours that 8 bits can say come out as they are, however the
// coefficients err.
struct YuvToRgb {
  static constexpr int kCoefficientBits = 13;
  static constexpr int kShift = kCoefficientBits + kFineBits;
  struct Channel {
    std::int16_t y = 0, u = 0, v = 0;
    std::int32_t start = 0;  // less what black and grey give, plus half a step
  };
  Channel red, green, blue;
};
// Of samples of `bits` bits, 8 or 10, and with colours of the ranges that ViewColour states. The steps of
// samples are those of 8 bits, so that of 10 the full range goes up to 255.75.
YuvToRgb yuv_to_rgb(YuvColour colour, const ViewColour& view = {}, int bits = 8);

// 1/32 to 31/32 of a step.
inline constexpr int kLeastThreshold = 1 << (YuvToRgb::kShift - 5);
constexpr int yuv_threshold(int x, int y) {
  constexpr int kBits = 15;
  constexpr int kTimes = ((1 << YuvToRgb::kShift) - 2 * kLeastThreshold) >> kBits;
  return kLeastThreshold + kTimes * static_cast<int>(dither_triangle(x, y) >> (31 - kBits));
}

// Y of what is outside the image; U and V are 128.
inline std::uint8_t black_luma(YuvRange range) {
  return range == YuvRange::kLimited ? 16 : 0;
}

// `count` pixels each. Luma without a footprint is black whatever the chroma says; chroma without one is
// grey. The fast ones write past the caches.
struct YuvRows {
  void (*luma)(const Luma* from, int count, std::uint8_t black, std::uint8_t* to) noexcept;
  void (*chroma)(const Chroma* from, int count, std::uint8_t* to) noexcept;  // bytes U V U V ...
  void (*xrgb)(const Luma* luma, const Chroma* chroma, int count, const YuvToRgb& matrix, Xrgb* to) noexcept;
  // The same, dithered, of pixels that go to (x, y) and on to the right.
  void (*xrgb_dithered)(const Luma* luma, const Chroma* chroma, int count, const YuvToRgb& matrix, int x,
                        int y, Xrgb* to) noexcept;
};
void convert_dithered_sse4(const Luma* luma, const Chroma* chroma, int count, const YuvToRgb& matrix, int x,
                           int y, Xrgb* to) noexcept;

extern const YuvRows kYuvRowsScalar;
extern const YuvRows kYuvRowsSse4;
extern const YuvRows kYuvRowsAvx512;

const YuvRows& yuv_rows(Cpu cpu);

}  // namespace cupola
