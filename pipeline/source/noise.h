// Deterministic chance for the generated worlds: dice for their layout, smooth noise for their surfaces.
// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>

#include "pipeline/optics/vector.h"

namespace cupola {

constexpr std::uint64_t scramble(std::uint64_t x) {  // splitmix64's finish
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  // From 0 up to 1.
  double roll() {
    state_ += 0x9e3779b97f4a7c15u;
    return static_cast<double>(scramble(state_) >> 11) * 0x1p-53;
  }
  double between(double least, double most) { return least + (most - least) * roll(); }

 private:
  std::uint64_t state_;
};

// From 0 to 1, smooth, with features about 1 wide.
inline double smooth_noise(const Vec2& p) {
  const double column = std::floor(p.x), row = std::floor(p.y);
  const auto at = [&](int right, int down) {
    const auto x = static_cast<std::uint64_t>(static_cast<std::int64_t>(column) + right);
    const auto y = static_cast<std::uint64_t>(static_cast<std::int64_t>(row) + down);
    return static_cast<double>(scramble(x * 0x9e3779b97f4a7c15u + y * 0xd1b54a32d192ed03u) >> 40) * 0x1p-24;
  };
  const double u = p.x - column, v = p.y - row;
  const double a = u * u * (3.0 - 2.0 * u), b = v * v * (3.0 - 2.0 * v);
  return (at(0, 0) * (1.0 - a) + at(1, 0) * a) * (1.0 - b) + (at(0, 1) * (1.0 - a) + at(1, 1) * a) * b;
}

}  // namespace cupola
