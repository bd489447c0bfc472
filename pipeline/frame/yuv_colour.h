// What the numbers of YUV pictures mean.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

namespace cupola {

// What red and blue weigh in luma; the rest is green's.
struct LumaWeights {
  double red = 0.2126;  // BT.709
  double blue = 0.0722;
  friend bool operator==(const LumaWeights&, const LumaWeights&) = default;
};

enum class YuvMatrix : std::uint8_t { kBt601, kBt709 };
enum class YuvRange : std::uint8_t {
  kLimited,  // Y 16 to 235, U and V 16 to 240
  kFull,     // all 0 to 255
};

struct YuvColour {
  YuvMatrix matrix = YuvMatrix::kBt601;
  YuvRange range = YuvRange::kLimited;
};

constexpr LumaWeights weights_of(YuvMatrix matrix) {
  return matrix == YuvMatrix::kBt709 ? LumaWeights{} : LumaWeights{0.299, 0.114};
}

// Red, green and blue of samples of 8 bits; black is 0 and white 255, what is beyond them is left so.
inline std::array<double, 3> rgb_of(YuvColour colour, double y, double u, double v) {
  const auto [red, blue] = weights_of(colour.matrix);
  const double green = 1.0 - red - blue;
  const bool limited = colour.range == YuvRange::kLimited;
  const double wide = limited ? 255.0 / 224.0 : 1.0;
  y = limited ? (y - 16.0) * 255.0 / 219.0 : y;
  u = (u - 128.0) * wide * 2.0 * (1.0 - blue);
  v = (v - 128.0) * wide * 2.0 * (1.0 - red);
  return {y + v, y - (u * blue + v * red) / green, y + u};
}

}  // namespace cupola
