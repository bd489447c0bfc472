// Footprints: within one view in one quick scan, across seams texel by texel.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/footprint.h"

#include <algorithm>
#include <cmath>

#include "pipeline/optics/portable_math.h"

namespace cupola {

// q = a U^2 + b U V + c V^2 about (u, v); the box is that of q < radius^2.
struct FootprintGatherer::Ellipse {
  double u, v;
  double a, b, c;
  double half_width, half_height;
};

namespace {

using Cone = portable::SineCosine;

// The covariance M = J J^T of the pixel in texels, both eigenvalues at least `least`, plus rec on the
// diagonal.
struct Covariance {
  double uu, uv, vv;
};

Covariance covariance(const View& home, const ViewSample& at, const DirectionAndSlope& looking,
                      const FilterSettings& filter) {
  const double ux = glm::dot(at.du, looking.d_da);
  const double uy = glm::dot(at.du, looking.d_db);
  const double vx = glm::dot(at.dv, looking.d_da);
  const double vy = glm::dot(at.dv, looking.d_db);
  Covariance m{ux * ux + uy * uy, ux * vx + uy * vy, vx * vx + vy * vy};
  const double least = smallest_axis(filter) * smallest_axis(filter);
  const double mean = (m.uu + m.vv) / 2;
  const double half = (m.uu - m.vv) / 2;
  const double spread = std::sqrt(half * half + m.uv * m.uv);
  const double large = mean + spread;
  const double small = mean - spread;
  if (large <= least) {
    m = {least, 0.0, least};
  } else if (small < least) {
    // M + (least - small) e e^T, where e e^T = (large I - M) / (large - small) is the smaller axis'
    // projector.
    const double lift = (least - small) / (large - small);
    m = {m.uu + lift * (large - m.uu), m.uv - lift * m.uv, m.vv + lift * (large - m.vv)};
  }
  m.uu += filter.rec;
  m.vv += filter.rec * home.rec_v;
  return m;
}

double kernel(const FilterSettings& filter, double q) {
  return portable::exponential(-filter.alpha * q);
}

int floor_to_int(double x) {
  return static_cast<int>(std::floor(x));
}

// A cone about `direction` that holds all of the ellipse's box.
Cone cone_of_box(const View& home, const Vec3& direction, const ViewSample& at, double wide, double high) {
  if (home.distortion == Distortion::kNone) {
    double least = 1.0;
    for (const double u : {at.uv.x - wide, at.uv.x + wide}) {
      for (const double v : {at.uv.y - high, at.uv.y + high}) {
        least = std::min(least, glm::dot(direction, direction_at(home, {u, v})));
      }
    }
    least = std::max(least, 0.001);
    return {std::sqrt((1.0 - least) * (1.0 + least)) + 1e-8, least};
  }
  // Texels a radian in the direction where they are fewest; the angle is doubled, since the model bends.
  const double uu = glm::dot(at.du, at.du);
  const double vv = glm::dot(at.dv, at.dv);
  const double uv = glm::dot(at.du, at.dv);
  const double half = (uu - vv) / 2;
  const double fewest = std::sqrt(std::max(1e-12, (uu + vv) / 2 - std::sqrt(half * half + uv * uv)));
  return portable::sine_cosine(std::min(2.0 * std::sqrt(wide * wide + high * high) / fewest, 1.57));
}

}  // namespace

bool FootprintGatherer::owns_whole_box(int home, const Vec3& direction, const Ellipse& e,
                                       const portable::SineCosine& cone) const {
  const View& own = rig_.views[static_cast<std::size_t>(home)];
  if (e.u - e.half_width < 0.0 || e.v - e.half_height < 0.0 || e.u + e.half_width > own.size.width ||
      e.v + e.half_height > own.size.height) {
    return false;
  }
  // A view is nearer than another on one side of a plane through the eye, with normal n = forward - other
  // forward. Directions within the angle a of d reach down to d.n cos a - |n| sin a.
  for (std::size_t i = 0; i < rig_.views.size(); ++i) {
    if (static_cast<int>(i) == home) continue;
    const Vec3 n = own.forward - rig_.views[i].forward;
    if (glm::dot(direction, n) * cone.cosine - glm::length(n) * cone.sine <= 1e-9) return false;
  }
  return true;
}

void FootprintGatherer::gather_inside(int view, const Ellipse& e, std::vector<Tap>& taps) const {
  const double limit = rig_.filter.radius * rig_.filter.radius;
  // Centres u + 0.5 within the box.
  const int x0 = floor_to_int(e.u - e.half_width + 0.5);
  const int x1 = floor_to_int(e.u + e.half_width - 0.5);
  const int y0 = floor_to_int(e.v - e.half_height + 0.5);
  const int y1 = floor_to_int(e.v + e.half_height - 0.5);
  for (int y = y0; y <= y1; ++y) {
    const double dv = y + 0.5 - e.v;
    for (int x = x0; x <= x1; ++x) {
      const double du = x + 0.5 - e.u;
      const double q = e.a * du * du + e.b * du * dv + e.c * dv * dv;
      if (q < limit) taps.push_back({x, y, view, kernel(rig_.filter, q)});
    }
  }
}

void FootprintGatherer::gather_across_seams(int home, const Vec3& direction, const Ellipse& e, double angle,
                                            std::vector<Tap>& taps) const {
  const View& plane = rig_.views[static_cast<std::size_t>(home)];
  const double limit = rig_.filter.radius * rig_.filter.radius;
  for (std::size_t i = 0; i < rig_.views.size(); ++i) {
    const View& own = rig_.views[i];
    const TexelBox box = texels_near(own, direction, angle);
    for (int y = box.y0; y < box.y1; ++y) {
      for (int x = box.x0; x < box.x1; ++x) {
        const Vec3 d = direction_at(own, {x + 0.5, y + 0.5});
        ViewSample in_plane;
        if (glm::dot(d, direction) <= 0.0 || !project(plane, d, in_plane)) continue;
        const bool at_home = static_cast<int>(i) == home;
        const double du = (at_home ? x + 0.5 : in_plane.uv.x) - e.u;
        const double dv = (at_home ? y + 0.5 : in_plane.uv.y) - e.v;
        const double q = e.a * du * du + e.b * du * dv + e.c * dv * dv;
        if (q >= limit || owner(rig_.views, d) != static_cast<int>(i)) continue;
        double weight = kernel(rig_.filter, q);
        if (!at_home) {
          ViewSample in_own;
          project(own, d, in_own);
          weight *= density(in_plane, d) / density(in_own, d);
        }
        taps.push_back({x, y, static_cast<int>(i), weight});
      }
    }
  }
}

Footprint FootprintGatherer::gather(int x, int y, std::vector<Tap>& taps) const {
  taps.clear();
  DirectionAndSlope looking;
  if (!ray(rig_.frame, {x + 0.5, y + 0.5}, looking)) return Footprint::kOutside;
  const int home = owner(rig_.views, looking.direction);
  ViewSample at;
  if (home < 0 || !project(rig_.views[static_cast<std::size_t>(home)], looking.direction, at)) {
    return Footprint::kUncovered;
  }
  const Covariance m = covariance(rig_.views[static_cast<std::size_t>(home)], at, looking, rig_.filter);
  const double f = m.uu * m.vv - m.uv * m.uv;
  const Ellipse ellipse{at.uv.x,
                        at.uv.y,
                        m.vv / f,
                        -2.0 * m.uv / f,
                        m.uu / f,
                        rig_.filter.radius * std::sqrt(m.uu),
                        rig_.filter.radius * std::sqrt(m.vv)};
  const Cone cone = cone_of_box(rig_.views[static_cast<std::size_t>(home)], looking.direction, at,
                                ellipse.half_width, ellipse.half_height);
  if (owns_whole_box(home, looking.direction, ellipse, cone)) {
    gather_inside(home, ellipse, taps);
  } else {
    gather_across_seams(home, looking.direction, ellipse, portable::arc_tangent2(cone.sine, cone.cosine),
                        taps);
  }
  double sum = 0.0;
  for (const Tap& tap : taps) sum += tap.weight;
  if (!(sum > 0.0)) {
    taps.clear();
    return Footprint::kUncovered;
  }
  for (Tap& tap : taps) tap.weight /= sum;
  return Footprint::kCovered;
}

}  // namespace cupola
