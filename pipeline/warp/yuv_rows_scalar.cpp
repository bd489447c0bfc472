// The definition of how luma and chroma leave.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "pipeline/warp/yuv_rows.h"

namespace cupola {
namespace {

constexpr int kGrey = 128 << kFineBits;

std::uint8_t rounded(std::uint16_t fine) {
  return static_cast<std::uint8_t>((fine + (1 << (kFineBits - 1))) >> kFineBits);
}

std::int16_t coefficient(double value) {
  return static_cast<std::int16_t>(std::lround(value * (1 << YuvToRgb::kCoefficientBits)));
}

void store_luma(const Luma* from, int count, std::uint8_t black, std::uint8_t* to) noexcept {
  for (int i = 0; i < count; ++i) to[i] = from[i] == kNoFine ? black : rounded(from[i]);
}

void store_chroma(const Chroma* from, int count, std::uint8_t* to) noexcept {
  for (int i = 0; i < count; ++i) {
    const bool grey = from[i].u == kNoFine;
    to[2 * i] = grey ? 128 : rounded(from[i].u);
    to[2 * i + 1] = grey ? 128 : rounded(from[i].v);
  }
}

void convert(const Luma* luma, const Chroma* chroma, int count, const YuvToRgb& matrix, Xrgb* to) noexcept {
  for (int i = 0; i < count; ++i) {
    if (luma[i] == kNoFine) {
      to[i] = kBlackXrgb;
      continue;
    }
    const bool grey = chroma[i].u == kNoFine;
    const int u = grey ? kGrey : chroma[i].u;
    const int v = grey ? kGrey : chroma[i].v;
    const auto sample = [&](const YuvToRgb::Channel& channel) {
      const int sum = channel.y * luma[i] + channel.u * u + channel.v * v + channel.start;
      return static_cast<Xrgb>(std::clamp(sum >> YuvToRgb::kShift, 0, 255));
    };
    to[i] = kBlackXrgb | sample(matrix.red) << 16 | sample(matrix.green) << 8 | sample(matrix.blue);
  }
}

}  // namespace

YuvToRgb yuv_to_rgb(YuvColour colour, const ViewColour& view) {
  // Shares of red and blue in luma; the rest is green.
  const auto [red, blue] = weights_of(colour.matrix);
  const double green = 1.0 - red - blue;
  const bool limited = colour.range == YuvRange::kLimited;
  const double wide = limited ? 255.0 / 224.0 : 1.0;
  const auto channel = [&](std::size_t c, double u, double v) {
    const double gain = view.gain[c];
    YuvToRgb::Channel made;
    made.y = coefficient(gain * (limited ? 255.0 / 219.0 : 1.0));
    made.u = coefficient(gain * u * wide);
    made.v = coefficient(gain * v * wide);
    made.start = (1 << (YuvToRgb::kShift - 1)) - (made.u + made.v) * kGrey -
                 made.y * (black_luma(colour.range) << kFineBits) +
                 static_cast<std::int32_t>(std::lround(view.offset[c] * (1 << YuvToRgb::kShift)));
    return made;
  };
  return {channel(0, 0.0, 2.0 * (1.0 - red)),
          channel(1, -2.0 * (1.0 - blue) * blue / green, -2.0 * (1.0 - red) * red / green),
          channel(2, 2.0 * (1.0 - blue), 0.0)};
}

const YuvRows kYuvRowsScalar{store_luma, store_chroma, convert};

}  // namespace cupola
