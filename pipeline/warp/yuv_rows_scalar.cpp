// The definition of how luma and chroma leave.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "pipeline/warp/yuv_rows.h"

namespace cupola {
namespace {

constexpr int kGrey = 128 << kFineBits;
constexpr int kHalfStep = 1 << (YuvToRgb::kShift - 1);

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

// `more`: than the half step that rounds to nearest.
Xrgb converted(Luma luma, const Chroma& chroma, const YuvToRgb& matrix, int more) {
  if (luma == kNoFine) return kBlackXrgb;
  const bool grey = chroma.u == kNoFine;
  const int u = grey ? kGrey : chroma.u;
  const int v = grey ? kGrey : chroma.v;
  const auto sample = [&](const YuvToRgb::Channel& channel) {
    const int sum = channel.y * luma + channel.u * u + channel.v * v + channel.start + more;
    return static_cast<Xrgb>(std::clamp(sum >> YuvToRgb::kShift, 0, 255));
  };
  return kBlackXrgb | sample(matrix.red) << 16 | sample(matrix.green) << 8 | sample(matrix.blue);
}

void convert(const Luma* luma, const Chroma* chroma, int count, const YuvToRgb& matrix, Xrgb* to) noexcept {
  for (int i = 0; i < count; ++i) to[i] = converted(luma[i], chroma[i], matrix, 0);
}

void convert_dithered(const Luma* luma, const Chroma* chroma, int count, const YuvToRgb& matrix, int x, int y,
                      Xrgb* to) noexcept {
  for (int i = 0; i < count; ++i)
    to[i] = converted(luma[i], chroma[i], matrix, yuv_threshold(x + i, y) - kHalfStep);
}

}  // namespace

YuvToRgb yuv_to_rgb(YuvColour colour, const ViewColour& view, int bits) {
  // Shares of red and blue in luma; the rest is green.
  const auto [red, blue] = weights_of(colour.matrix);
  const double green = 1.0 - red - blue;
  const bool limited = colour.range == YuvRange::kLimited;
  const double full = bits == 8 ? 1.0 : 255.0 / 255.75;
  const double wide = limited ? 255.0 / 224.0 : full;
  const auto channel = [&](std::size_t c, double u, double v) {
    const double gain = view.gain[c];
    YuvToRgb::Channel made;
    made.y = coefficient(gain * (limited ? 255.0 / 219.0 : full));
    made.u = coefficient(gain * u * wide);
    made.v = coefficient(gain * v * wide);
    made.start = kHalfStep - (made.u + made.v) * kGrey - made.y * (black_luma(colour.range) << kFineBits) +
                 static_cast<std::int32_t>(std::lround(view.offset[c] * (1 << YuvToRgb::kShift)));
    return made;
  };
  return {channel(0, 0.0, 2.0 * (1.0 - red)),
          channel(1, -2.0 * (1.0 - blue) * blue / green, -2.0 * (1.0 - red) * red / green),
          channel(2, 2.0 * (1.0 - blue), 0.0)};
}

const YuvRows kYuvRowsScalar{store_luma, store_chroma, convert, convert_dithered};

}  // namespace cupola
