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

// The covariance M = J J^T of the pixel in texels, both eigenvalues at least `least`, plus rec on the
// diagonal.
struct Covariance {
  double uu, uv, vv;
};

Covariance covariance(const ViewSample& at, const DirectionAndSlope& looking, const FilterSettings& filter) {
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
  m.vv += filter.rec;
  return m;
}

double kernel(const FilterSettings& filter, double q) {
  return portable::exponential(-filter.alpha * q);
}

int floor_to_int(double x) {
  return static_cast<int>(std::floor(x));
}

// An angle about `direction` that holds all texels within the ellipse's box.
double angle_of_box(const View& home, const Vec3& direction, const ViewSample& at, double wide, double high) {
  double least = 1.0;
  if (home.distortion == Distortion::kNone) {
    for (const double u : {at.uv.x - wide, at.uv.x + wide}) {
      for (const double v : {at.uv.y - high, at.uv.y + high}) {
        least = std::min(least, glm::dot(direction, direction_at(home, {u, v})));
      }
    }
    const double cosine = std::max(least, -1.0);
    const double angle = portable::arc_tangent2(std::sqrt(std::max(0.0, 1.0 - cosine * cosine)), cosine);
    return std::min(angle + 1e-9, 1.57);
  }
  const double uu = glm::dot(at.du, at.du);
  const double vv = glm::dot(at.dv, at.dv);
  const double uv = glm::dot(at.du, at.dv);
  const double half = (uu - vv) / 2;
  const double fewest = std::sqrt(std::max(1e-12, (uu + vv) / 2 - std::sqrt(half * half + uv * uv)));
  return std::min(2.0 * std::sqrt(wide * wide + high * high) / fewest, 1.5);
}

}  // namespace

FootprintGatherer::FootprintGatherer(const Rig& rig) : rig_(rig), borders_(rig.views.size()) {
  for (std::size_t i = 0; i < rig.views.size(); ++i) {
    const View& view = rig.views[i];
    if (view.distortion != Distortion::kNone) continue;
    // A point of the plane is forward + right p - up q with p, q linear in (u, v).
    const double p_u = 1.0 / (view.focal.x * view.size.width);
    const double p_0 = -view.principal.x / view.focal.x;
    const double q_v = 1.0 / (view.focal.y * view.size.height);
    const double q_0 = -view.principal.y / view.focal.y;
    for (std::size_t k = 0; k < rig.views.size(); ++k) {
      if (k == i) continue;
      const Vec3 nearer = view.forward - rig.views[k].forward;
      const double along_p = glm::dot(nearer, view.right);
      const double along_q = -glm::dot(nearer, view.up);
      borders_[i].push_back(
          {along_p * p_u, along_q * q_v, glm::dot(nearer, view.forward) + along_p * p_0 + along_q * q_0});
    }
  }
}

bool FootprintGatherer::owns_whole_box(std::size_t view, const Ellipse& e) const {
  const View& own = rig_.views[view];
  if (own.distortion != Distortion::kNone) return false;
  if (e.u - e.half_width < 0.0 || e.v - e.half_height < 0.0 || e.u + e.half_width > own.size.width ||
      e.v + e.half_height > own.size.height) {
    return false;
  }
  return std::all_of(borders_[view].begin(), borders_[view].end(), [&](const HalfPlane& h) {
    return h.a * e.u + h.b * e.v + h.c - std::abs(h.a) * e.half_width - std::abs(h.b) * e.half_height > 1e-9;
  });
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

void FootprintGatherer::gather_across_seams(int home, const Vec3& direction, const ViewSample& at,
                                            const Ellipse& e, std::vector<Tap>& taps) const {
  const View& plane = rig_.views[static_cast<std::size_t>(home)];
  const double limit = rig_.filter.radius * rig_.filter.radius;
  const double angle = angle_of_box(plane, direction, at, e.half_width, e.half_height);
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
  const Covariance m = covariance(at, looking, rig_.filter);
  const double f = m.uu * m.vv - m.uv * m.uv;
  const Ellipse ellipse{at.uv.x,
                        at.uv.y,
                        m.vv / f,
                        -2.0 * m.uv / f,
                        m.uu / f,
                        rig_.filter.radius * std::sqrt(m.uu),
                        rig_.filter.radius * std::sqrt(m.vv)};
  if (owns_whole_box(static_cast<std::size_t>(home), ellipse)) {
    gather_inside(home, ellipse, taps);
  } else {
    gather_across_seams(home, looking.direction, at, ellipse, taps);
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
