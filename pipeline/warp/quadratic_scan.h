// A quadratic over a grid by finite differences: two additions a step, in floating point or in integers
// (Greene & Heckbert 1986, the pseudocode on page 25).
// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <type_traits>

namespace cupola {

// Integers carry this many bits behind the point. Each of the three differences is rounded by up to half a
// step of 2^-20, so that after n texels along and m rows down Q is off by less than (n + m)^2 2^-21 + n m
// 2^-21.
inline constexpr int kScanFractionBits = 20;

template <class Number>
Number to_scan_number(double value) {
  if constexpr (std::is_integral_v<Number>) {
    return static_cast<Number>(std::llround(std::ldexp(value, kScanFractionBits)));
  } else {
    return static_cast<Number>(value);
  }
}

// Q = a u^2 + b u v + c v^2 at the first place of a row, and its differences. Copies of it are walked along
// a row by right(), the original from row to row by down().
template <class Number>
struct QuadraticScan {
  Number q, dq, ddq;  // along u
  Number dv, ddv;     // along v
  Number cross;       // b: change of either difference a step of the other

  void right() {
    q += dq;
    dq += ddq;
  }
  void down() {
    q += dv;
    dv += ddv;
    dq += cross;
  }
};

template <class Number>
QuadraticScan<Number> scan_from(double a, double b, double c, double u, double v) {
  const auto number = to_scan_number<Number>;
  return {number(a * u * u + b * u * v + c * v * v),
          number(a * (2.0 * u + 1.0) + b * v),
          number(2.0 * a),
          number(c * (2.0 * v + 1.0) + b * u),
          number(2.0 * c),
          number(b)};
}

}  // namespace cupola
