// A square clipped by a parallelogram's four sides.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/coverage.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cupola {
namespace {

struct Point {
  double x, y;
};

// A convex polygon of up to 8 corners.
struct Polygon {
  std::array<Point, 8> corner;
  int count = 0;
  void add(Point p) { corner[count++] = p; }
};

// Keeps what has sign * coordinate <= 1/2.
Polygon clipped(const Polygon& in, double Point::*coordinate, double sign) {
  Polygon out;
  for (int i = 0; i < in.count; ++i) {
    const Point a = in.corner[i];
    const Point b = in.corner[(i + 1) % in.count];
    const double over_a = sign * a.*coordinate - 0.5;
    const double over_b = sign * b.*coordinate - 0.5;
    if (over_a <= 0.0) out.add(a);
    if ((over_a < 0.0) != (over_b < 0.0) && over_a != 0.0 && over_b != 0.0) {
      const double t = over_a / (over_a - over_b);
      out.add({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
    }
  }
  return out;
}

double area(const Polygon& polygon) {
  double twice = 0.0;
  for (int i = 0; i < polygon.count; ++i) {
    const Point& a = polygon.corner[i];
    const Point& b = polygon.corner[(i + 1) % polygon.count];
    twice += a.x * b.y - b.x * a.y;
  }
  return std::abs(twice) / 2.0;
}

// J = s1 e1 f1^T + s2 e2 f2^T; e1 along the longer axis of J J^T.
PixelArea raised(const PixelArea& j) {
  const double uu = j.ux * j.ux + j.uy * j.uy;
  const double uv = j.ux * j.vx + j.uy * j.vy;
  const double vv = j.vx * j.vx + j.vy * j.vy;
  const double half = (uu - vv) / 2.0;
  const double large = (uu + vv) / 2.0 + std::sqrt(half * half + uv * uv);
  const double determinant = j.ux * j.vy - j.uy * j.vx;
  const double s1 = std::sqrt(large);
  const double s2 = s1 > 0.0 ? std::abs(determinant) / s1 : 0.0;
  if (s2 >= 1.0) return j;
  if (!(s1 > 1e-12)) return {j.u, j.v, 1.0, 0.0, 0.0, 1.0};
  // (large I - M) e1 = 0: the row of the larger size is perpendicular to e1.
  double eu = uu >= vv ? large - vv : uv;
  double ev = uu >= vv ? uv : large - uu;
  const double length = std::sqrt(eu * eu + ev * ev);
  if (length > 0.0) {
    eu /= length;
    ev /= length;
  } else {
    eu = 1.0;  // a circle: any axis
    ev = 0.0;
  }
  const double fx = (j.ux * eu + j.vx * ev) / s1;
  const double fy = (j.uy * eu + j.vy * ev) / s1;
  const double a = std::max(s1, 1.0);
  const double b = determinant < 0.0 ? -1.0 : 1.0;
  return {j.u,
          j.v,
          a * eu * fx + b * ev * fy,
          a * eu * fy - b * ev * fx,
          a * ev * fx - b * eu * fy,
          a * ev * fy + b * eu * fx};
}

}  // namespace

Coverage::Coverage(const PixelArea& area) {
  const PixelArea j = raised(area);
  ux_ = j.ux;
  uy_ = j.uy;
  vx_ = j.vx;
  vy_ = j.vy;
  const double determinant = ux_ * vy_ - uy_ * vx_;
  to_x_u_ = vy_ / determinant;
  to_x_v_ = -uy_ / determinant;
  to_y_u_ = -vx_ / determinant;
  to_y_v_ = ux_ / determinant;
}

double Coverage::half_width() const {
  return (std::abs(ux_) + std::abs(uy_) + 1.0) / 2.0;
}

double Coverage::half_height() const {
  return (std::abs(vx_) + std::abs(vy_) + 1.0) / 2.0;
}

double Coverage::operator()(double du, double dv) const {
  // In the pixel's own coordinates the parallelogram is the unit square, the texel a parallelogram.
  const double x = to_x_u_ * du + to_x_v_ * dv;
  const double y = to_y_u_ * du + to_y_v_ * dv;
  const double reach_x = (std::abs(to_x_u_) + std::abs(to_x_v_)) / 2.0;
  const double reach_y = (std::abs(to_y_u_) + std::abs(to_y_v_)) / 2.0;
  if (std::abs(x) >= 0.5 + reach_x || std::abs(y) >= 0.5 + reach_y) return 0.0;
  if (std::abs(x) + reach_x <= 0.5 && std::abs(y) + reach_y <= 0.5) return 1.0;
  Polygon texel;
  for (const auto& [u, v] : {Point{-0.5, -0.5}, Point{0.5, -0.5}, Point{0.5, 0.5}, Point{-0.5, 0.5}}) {
    texel.add({x + to_x_u_ * u + to_x_v_ * v, y + to_y_u_ * u + to_y_v_ * v});
  }
  texel = clipped(texel, &Point::x, 1.0);
  texel = clipped(texel, &Point::x, -1.0);
  texel = clipped(texel, &Point::y, 1.0);
  texel = clipped(texel, &Point::y, -1.0);
  return std::min(1.0, area(texel) * std::abs(ux_ * vy_ - uy_ * vx_));
}

}  // namespace cupola
