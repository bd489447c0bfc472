// Projection onto views and back, with exact gradients.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/view.h"

#include <algorithm>
#include <cmath>

#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

// A point of the ideal image plane at distance 1, or its distorted image: a rightward, b downward.
struct PlanePoint {
  double a, b;
};

// d(distorted) / d(ideal).
struct PlaneJacobian {
  double aa, ab, ba, bb;
};

// OpenCV's model: radial factor (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6), then p1, p2.
PlanePoint bend(const std::array<double, 8>& c, PlanePoint p, PlaneJacobian& j) {
  const auto [k1, k2, p1, p2, k3, k4, k5, k6] = c;
  const double y = p.a * p.a + p.b * p.b;
  const double top = 1.0 + y * (k1 + y * (k2 + y * k3));
  const double bottom = 1.0 + y * (k4 + y * (k5 + y * k6));
  const double factor = top / bottom;
  const double d_top = k1 + y * (2.0 * k2 + y * 3.0 * k3);
  const double d_bottom = k4 + y * (2.0 * k5 + y * 3.0 * k6);
  const double d_factor = (d_top - factor * d_bottom) / bottom;  // by y
  j.aa = factor + 2.0 * p.a * p.a * d_factor + 2.0 * p1 * p.b + 6.0 * p2 * p.a;
  j.ab = 2.0 * p.a * p.b * d_factor + 2.0 * p1 * p.a + 2.0 * p2 * p.b;
  j.ba = j.ab;
  j.bb = factor + 2.0 * p.b * p.b * d_factor + 6.0 * p1 * p.b + 2.0 * p2 * p.a;
  return {p.a * factor + 2.0 * p1 * p.a * p.b + p2 * (y + 2.0 * p.a * p.a),
          p.b * factor + p1 * (y + 2.0 * p.b * p.b) + 2.0 * p2 * p.a * p.b};
}

PlanePoint unbend(const std::array<double, 8>& c, PlanePoint target) {
  PlanePoint p = target;
  for (int i = 0; i < 50; ++i) {
    PlaneJacobian j{};
    const PlanePoint now = bend(c, p, j);
    const double ea = now.a - target.a;
    const double eb = now.b - target.b;
    const double det = j.aa * j.bb - j.ab * j.ba;
    const double da = (j.bb * ea - j.ab * eb) / det;
    const double db = (j.aa * eb - j.ba * ea) / det;
    p.a -= da;
    p.b -= db;
    if (std::abs(da) + std::abs(db) < 1e-15 * (1.0 + std::abs(p.a) + std::abs(p.b))) break;
  }
  return p;
}

// OpenCV's fisheye: distorted radius of an angle, and its derivative.
double fisheye_radius(const std::array<double, 8>& k, double angle, double& slope) {
  const double y = angle * angle;
  slope = 1.0 + y * (3.0 * k[0] + y * (5.0 * k[1] + y * (7.0 * k[2] + y * 9.0 * k[3])));
  return angle * (1.0 + y * (k[0] + y * (k[1] + y * (k[2] + y * k[3]))));
}

double fisheye_angle(const std::array<double, 8>& k, double radius, double limit) {
  double low = 0.0;
  double high = limit;
  double angle = std::min(radius, limit);
  for (int i = 0; i < 100; ++i) {
    double slope = 0.0;
    const double error = fisheye_radius(k, angle, slope) - radius;
    (error < 0.0 ? low : high) = angle;
    double next = angle - error / slope;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    if (std::abs(next - angle) < 1e-15) return next;
    angle = next;
  }
  return angle;
}

// The distorted plane point of direction `d`, and unless kGradients is false its gradients by d. False where
// the model does not reach.
template <bool kGradients>
bool plane_point_at_eye(const View& view, const Vec3& d, PlanePoint& p, Vec3& da, Vec3& db) {
  const double x = glm::dot(d, view.right);
  const double y = glm::dot(d, view.up);
  const double z = glm::dot(d, view.forward);
  const double square = glm::dot(d, d);
  if (view.distortion == Distortion::kFisheye) {
    const double rho = std::sqrt(x * x + y * y);
    const double angle = portable::arc_tangent2(rho, z);
    if (angle > view.limit) return false;
    double slope = 0.0;
    const double radius = fisheye_radius(view.coefficients, angle, slope);
    if (rho < 1e-9 * std::abs(z)) {
      // Straight behind is a whole circle of the picture; on the axis the model is the plane's, radius =
      // angle.
      if (z <= 0.0) return false;
      p = {x / z, -y / z};
      da = (view.right - p.a * view.forward) / z;
      db = (-view.up - p.b * view.forward) / z;
      return true;
    }
    const Vec3 d_rho = (x * view.right + y * view.up) / rho;
    const Vec3 d_angle = (z * d_rho - rho * view.forward) / square;
    const double h = radius / rho;
    const Vec3 d_h = (slope * d_angle - h * d_rho) / rho;
    p = {h * x, -h * y};
    da = x * d_h + h * view.right;
    db = -(y * d_h + h * view.up);
    return true;
  }
  if (!(z > 0.0 && z * z > 1e-12 * square)) return false;
  p = {x / z, -y / z};
  if constexpr (kGradients) {
    da = (view.right - p.a * view.forward) / z;
    db = (-view.up - p.b * view.forward) / z;
  }
  if (view.distortion == Distortion::kRadialTangential) {
    if (p.a * p.a + p.b * p.b > view.limit * view.limit) return false;
    PlaneJacobian j{};
    p = bend(view.coefficients, p, j);
    if constexpr (kGradients) {
      const Vec3 ideal_da = da;
      da = j.aa * ideal_da + j.ab * db;
      db = j.ba * ideal_da + j.bb * db;
    }
  }
  return true;
}

// The same from the rig's centre: w = d - |d| s, and dw/dd = I - s d^T / |d|.
template <bool kGradients>
bool plane_point(const View& view, const Vec3& d, PlanePoint& p, Vec3& da, Vec3& db) {
  if (!is_shifted(view)) return plane_point_at_eye<kGradients>(view, d, p, da, db);
  const double length = std::sqrt(glm::dot(d, d));
  if (!plane_point_at_eye<kGradients>(view, d - length * view.shift, p, da, db)) return false;
  if constexpr (kGradients) {
    const Vec3 unit = d / length;
    da -= glm::dot(da, view.shift) * unit;
    db -= glm::dot(db, view.shift) * unit;
  }
  return true;
}

// Where the eye's unit direction `w` meets the unit sphere about the rig's centre: |s + t w| = 1, t > 0.
Vec3 seen_from_centre(const View& view, const Vec3& w) {
  if (!is_shifted(view)) return w;
  const double along = glm::dot(view.shift, w);
  const double t = std::sqrt(along * along + (1.0 - glm::dot(view.shift, view.shift))) - along;
  return glm::normalize(view.shift + t * w);
}

// Position within the picture as shares of its width and height, 0 to 1 inside.
bool share(const View& view, const Vec3& d, Vec2& at) {
  PlanePoint p{};
  Vec3 da;
  Vec3 db;
  if (!plane_point<false>(view, d, p, da, db)) return false;
  at = {p.a * view.focal.x + view.principal.x, p.b * view.focal.y + view.principal.y};
  return true;
}

Vec3 direction_at_eye(const View& view, const Vec2& uv) {
  PlanePoint p{(uv.x / view.size.width - view.principal.x) / view.focal.x,
               (uv.y / view.size.height - view.principal.y) / view.focal.y};
  if (view.distortion == Distortion::kFisheye) {
    const double radius = std::sqrt(p.a * p.a + p.b * p.b);
    if (radius < 1e-12) return view.forward;
    const double angle = fisheye_angle(view.coefficients, radius, view.limit);
    const auto [sine, cosine] = portable::sine_cosine(angle);
    return view.forward * cosine + (view.right * p.a - view.up * p.b) * (sine / radius);
  }
  if (view.distortion == Distortion::kRadialTangential) p = unbend(view.coefficients, p);
  return glm::normalize(view.forward + view.right * p.a - view.up * p.b);
}

// Range of x / z over directions within `angle` of one whose components are (x, z): the plane through the
// eye and a column of texels touches the cone where its own angle from the axis does.
void tangent_range(double x, double z, double angle, double& least, double& most) {
  const double reach = std::sqrt(x * x + z * z);
  const double sine = portable::sine_cosine(angle).sine;
  least = -HUGE_VAL;
  most = HUGE_VAL;
  if (sine >= reach) return;
  const double middle = portable::arc_tangent2(x, z);
  const double spread = portable::arc_sine(sine / reach);
  constexpr double kEdge = portable::kPi / 2 - 1e-6;
  if (middle - spread > kEdge || middle + spread < -kEdge) {
    least = HUGE_VAL;  // wholly behind
    most = -HUGE_VAL;
    return;
  }
  if (middle - spread > -kEdge) least = portable::tangent(middle - spread);
  if (middle + spread < kEdge) most = portable::tangent(middle + spread);
}

struct EyeCone {
  Vec3 axis;
  double angle;
};

// A cone that holds, as the eye sees it, all that lies within `angle` of `axis` from the centre. A step on
// the unit sphere is seen from the eye at most 1 / (1 - |s|) times as large, that being its distance from
// there.
EyeCone cone_at_eye(const View& view, const Vec3& axis, double angle) {
  if (!is_shifted(view)) return {axis, angle};
  return {glm::normalize(axis - view.shift), angle / (1.0 - glm::length(view.shift))};
}

// Whether a cone about (x, y, z), along right, up and forward, lies wholly beyond one of the four planes
// through the eye and the picture's sides.
bool misses_picture(const View& view, double x, double y, double z, double sine) {
  const auto beyond = [&](double along, double edge) {  // along - edge z < 0 outside
    return along - edge * z < -sine * std::sqrt(1.0 + edge * edge);
  };
  return beyond(x, -view.principal.x / view.focal.x) || beyond(-x, (view.principal.x - 1.0) / view.focal.x) ||
         beyond(-y, -view.principal.y / view.focal.y) || beyond(y, (view.principal.y - 1.0) / view.focal.y);
}

// The box about the cone's rim, seen through the model at 32 points; widened by a quarter for what bends
// between them. Rim points that the model does not reach are left out: the model is one-to-one over the whole
// picture.
TexelBox distorted_texels_near(const View& view, const Vec3& axis, double angle) {
  const Size size = view.size;
  if (angle > 0.5) return {0, 0, size.width, size.height};
  const Vec3 aside = glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const Vec3 across = glm::cross(axis, aside);
  const auto [sine, cosine] = portable::sine_cosine(angle);
  Vec2 least{HUGE_VAL, HUGE_VAL};
  Vec2 most{-HUGE_VAL, -HUGE_VAL};
  constexpr int kPoints = 32;
  for (int i = 0; i <= kPoints; ++i) {
    const auto [y, x] = portable::sine_cosine(i * (2.0 * portable::kPi / kPoints));
    const Vec3 d = i == kPoints ? axis : axis * cosine + (aside * x + across * y) * sine;
    Vec2 uv;
    if (!project(view, d, uv)) continue;
    least = glm::min(least, uv);
    most = glm::max(most, uv);
  }
  if (least.x > most.x) return {};
  const Vec2 margin = (most - least) * 0.25 + Vec2{2.0, 2.0};
  const auto texel = [](double at, int side) {
    return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(side)));
  };
  return {texel(std::floor(least.x - margin.x), size.width),
          texel(std::floor(least.y - margin.y), size.height), texel(std::ceil(most.x + margin.x), size.width),
          texel(std::ceil(most.y + margin.y), size.height)};
}

}  // namespace

bool named_pose(std::string_view name, View& view) {
  struct Pose {
    std::string_view name;
    Vec3 forward, right, up;
  };
  static const Pose kPoses[] = {
      {"front", {0, 0, -1}, {1, 0, 0}, {0, 1, 0}},   {"left", {-1, 0, 0}, {0, 0, -1}, {0, 1, 0}},
      {"right", {1, 0, 0}, {0, 0, 1}, {0, 1, 0}},    {"top", {0, 1, 0}, {1, 0, 0}, {0, 0, 1}},
      {"bottom", {0, -1, 0}, {1, 0, 0}, {0, 0, -1}}, {"back", {0, 0, 1}, {-1, 0, 0}, {0, 1, 0}},
  };
  for (const Pose& pose : kPoses) {
    if (pose.name != name) continue;
    view.forward = pose.forward;
    view.right = pose.right;
    view.up = pose.up;
    return true;
  }
  return false;
}

bool project(const View& view, const Vec3& d, Vec2& uv) {
  if (!share(view, d, uv)) return false;
  uv = {uv.x * view.size.width, uv.y * view.size.height};
  return true;
}

bool project(const View& view, const Vec3& d, ViewSample& sample) {
  PlanePoint p{};
  if (!plane_point<true>(view, d, p, sample.du, sample.dv)) return false;
  const double width = view.size.width;
  const double height = view.size.height;
  sample.uv = {(p.a * view.focal.x + view.principal.x) * width,
               (p.b * view.focal.y + view.principal.y) * height};
  sample.du *= view.focal.x * width;
  sample.dv *= view.focal.y * height;
  return true;
}

Vec3 direction_at(const View& view, const Vec2& uv) {
  return seen_from_centre(view, direction_at_eye(view, uv));
}

bool covers(const View& view, const Vec3& d) {
  // A millionth of a texel more than the picture, so that no ray slips between two faces that share an edge.
  constexpr double kSlack = 1e-9;
  Vec2 at;
  return share(view, d, at) && at.x >= -kSlack && at.x <= 1.0 + kSlack && at.y >= -kSlack &&
         at.y <= 1.0 + kSlack;
}

int owner(std::span<const View> views, const Vec3& d) {
  int best = -1;
  double best_cosine = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double cosine = glm::dot(d, views[i].forward);
    if ((best < 0 || cosine > best_cosine) && covers(views[i], d)) {
      best = static_cast<int>(i);
      best_cosine = cosine;
    }
  }
  return best;
}

TexelBox texels_near(const View& view, const Vec3& around, double within) {
  const int width = view.size.width;
  const int height = view.size.height;
  if (view.distortion != Distortion::kNone) return distorted_texels_near(view, around, within);
  const auto [axis, angle] = cone_at_eye(view, around, within);
  if (angle > kFarthest) return {0, 0, width, height};
  const double x = glm::dot(axis, view.right);
  const double y = glm::dot(axis, view.up);
  const double z = glm::dot(axis, view.forward);
  if (misses_picture(view, x, y, z, portable::sine_cosine(angle).sine)) return {};
  double a0 = 0.0;
  double a1 = 0.0;
  double b0 = 0.0;
  double b1 = 0.0;
  tangent_range(x, z, angle, a0, a1);
  tangent_range(-y, z, angle, b0, b1);
  if (a0 > a1 || b0 > b1) return {};
  const auto texel = [](double tangent, double focal, double principal, int size) {
    return std::clamp((tangent * focal + principal) * size, 0.0, static_cast<double>(size));
  };
  return {static_cast<int>(std::floor(texel(a0, view.focal.x, view.principal.x, width))),
          static_cast<int>(std::floor(texel(b0, view.focal.y, view.principal.y, height))),
          static_cast<int>(std::ceil(texel(a1, view.focal.x, view.principal.x, width))),
          static_cast<int>(std::ceil(texel(b1, view.focal.y, view.principal.y, height)))};
}

}  // namespace cupola
