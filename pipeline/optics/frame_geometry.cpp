// Rays of the frame models with analytic derivatives.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/frame_geometry.h"

#include <algorithm>
#include <cmath>

#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

// d = (x s, y s, -cos phi) with s = sin(phi) / r, which is smooth through the centre.
bool fisheye_ray(const FrameGeometry& frame, const Vec2& p, DirectionAndSlope& ray) {
  const double x = (p.x - frame.center.x) / frame.radius;
  const double y = (frame.center.y - p.y) / frame.radius;
  const double r = std::sqrt(x * x + y * y);
  if (r > 1.0) return false;
  const auto [phi, slope] = sample(frame.lens, r);
  const auto [sine, cosine] = portable::sine_cosine(phi);
  const bool at_centre = r < 1e-8;
  const double s = at_centre ? slope : sine / r;
  const double ds = at_centre ? 0.0 : (slope * cosine - s) / (r * r);  // (ds / dr) / r
  ray.direction = {x * s, y * s, -cosine};
  const Vec3 d_dx{s + x * x * ds, x * y * ds, s * slope * x};
  const Vec3 d_dy{x * y * ds, s + y * y * ds, s * slope * y};
  ray.d_da = d_dx / frame.radius;
  ray.d_db = -d_dy / frame.radius;
  return true;
}

bool world_map_ray(const FrameGeometry& frame, const Vec2& p, DirectionAndSlope& ray) {
  const double per_pixel = frame.fov / frame.size.width;
  const double t = (frame.size.height / 2.0 - p.y) * per_pixel;
  double sine = 0.0;  // of the latitude
  double cosine = 0.0;
  double latitude_dt = 1.0;
  if (frame.model == FrameModel::kEquirectangular) {
    if (std::abs(t) > portable::kPi / 2) return false;
    const auto both = portable::sine_cosine(t);
    sine = both.sine;
    cosine = both.cosine;
  } else if (frame.model == FrameModel::kCylindrical) {
    cosine = 1.0 / std::sqrt(1.0 + t * t);
    sine = t * cosine;
    latitude_dt = cosine * cosine;
  } else {  // Mercator: sin(latitude) = tanh(t)
    const double e = portable::exponential(-2.0 * std::abs(t));
    sine = std::copysign((1.0 - e) / (1.0 + e), t);
    cosine = 2.0 * std::sqrt(e) / (1.0 + e);
    latitude_dt = cosine;
  }
  const auto [sin_lon, cos_lon] = portable::sine_cosine((p.x - frame.size.width / 2.0) * per_pixel);
  ray.direction = {cosine * sin_lon, sine, -cosine * cos_lon};
  ray.d_da = Vec3{cosine * cos_lon, 0.0, cosine * sin_lon} * per_pixel;
  ray.d_db = Vec3{-sine * sin_lon, cosine, sine * cos_lon} * (-latitude_dt * per_pixel);
  return true;
}

// The normal is n = (x, y, h); the line of sight (0, 0, -1) leaves along (2 h x, 2 h y, 2 h^2 - 1).
bool chrome_ball_ray(const FrameGeometry& frame, const Vec2& p, DirectionAndSlope& ray) {
  const double x = (p.x - frame.center.x) / frame.radius;
  const double y = (frame.center.y - p.y) / frame.radius;
  const double square = x * x + y * y;
  if (square > 1.0) return false;
  const double h = std::max(1e-6, std::sqrt(1.0 - square));  // at the limb the ray turns infinitely fast
  ray.direction = {2.0 * h * x, 2.0 * h * y, 2.0 * h * h - 1.0};
  ray.d_da = Vec3{2.0 * h - 2.0 * x * x / h, -2.0 * x * y / h, -4.0 * x} / frame.radius;
  ray.d_db = -Vec3{-2.0 * x * y / h, 2.0 * h - 2.0 * y * y / h, -4.0 * y} / frame.radius;
  return true;
}

bool cube_ray(const FrameGeometry& frame, const Vec2& p, DirectionAndSlope& ray) {
  const Size cell = frame.faces.front().size;
  const int column = std::clamp(static_cast<int>(p.x / cell.width), 0, frame.columns - 1);
  const int row = static_cast<int>(p.y / cell.height);
  const int index = row * frame.columns + column;
  if (index < 0 || index >= static_cast<int>(frame.faces.size())) return false;
  const View& face = frame.faces[static_cast<std::size_t>(index)];
  const double a_scale = 1.0 / (face.focal.x * cell.width);
  const double b_scale = 1.0 / (face.focal.y * cell.height);
  const double a = (p.x - column * cell.width - face.principal.x * cell.width) * a_scale;
  const double b = (p.y - row * cell.height - face.principal.y * cell.height) * b_scale;
  const Vec3 v = face.forward + face.right * a - face.up * b;
  const double length = glm::length(v);
  ray.direction = v / length;
  const auto across = [&](const Vec3& step) {
    return (step - ray.direction * glm::dot(ray.direction, step)) / length;
  };
  ray.d_da = across(face.right * a_scale);
  ray.d_db = across(face.up * -b_scale);
  return true;
}

bool model_ray(const FrameGeometry& frame, const Vec2& p, DirectionAndSlope& ray) {
  switch (frame.model) {
    case FrameModel::kFisheye:
      return fisheye_ray(frame, p, ray);
    case FrameModel::kChromeBall:
      return chrome_ball_ray(frame, p, ray);
    case FrameModel::kCube:
      return cube_ray(frame, p, ray);
    default:
      return world_map_ray(frame, p, ray);
  }
}

}  // namespace

bool ray(const FrameGeometry& frame, const Vec2& p, DirectionAndSlope& out) {
  if (!model_ray(frame, p, out)) return false;
  return frame.crop == Crop::kNone || out.direction.y >= out.direction.z;
}

}  // namespace cupola
