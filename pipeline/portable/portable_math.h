// The few transcendental functions of the geometry, with the same bits on every machine: the C library picks
// variants by CPU (with and without fused multiply-add) whose last bits differ, and tables must not.
// Error below 1e-15, relative; of sine and cosine absolute where the result is below 1.
// Only +, -, *, /, sqrt and exact conversions are used; compiled with -ffp-contract=off.
// SPDX-License-Identifier: MIT
#pragma once

namespace cupola::portable {

inline constexpr double kPi = 3.14159265358979323846;

struct SineCosine {
  double sine;
  double cosine;
};

SineCosine sine_cosine(double radians);   // |radians| up to 1e5
double tangent(double radians);           // the same
double arc_tangent2(double y, double x);  // in [-pi, pi]; 0 for (0, 0)
double arc_sine(double x);                // x in [-1, 1]; NaN outside
double exponential(double x);             // 0 below -700, x at most 700
double logarithm(double x);               // natural, of a normal x > 0; absolute where the result is below 1
double power(double x, double y);         // x >= 0, y > 0; error of y ln x, which grows with its size
double bessel_j1(double x);               // |x| <= 100; absolute error below 1e-15

constexpr double radians(double degrees) {
  return degrees * (kPi / 180.0);
}

}  // namespace cupola::portable
