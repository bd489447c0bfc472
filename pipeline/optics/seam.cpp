// Shares by angles, in the portable functions: tables hold them.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/seam.h"

#include <algorithm>
#include <cmath>

#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

double smooth(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

double angle_between(const Vec3& a, const Vec3& b) {
  const Vec3 across = glm::cross(a, b);
  return portable::arc_tangent2(std::sqrt(glm::dot(across, across)), glm::dot(a, b));
}

// Of a ray inside the picture, in radians: as many texels as it is from the edge, each as wide as those
// around the ray are on average.
double distance_from_edge(const View& view, const Vec3& d) {
  ViewSample at;
  if (!project(view, d, at)) return 0.0;
  const double texels = std::min({at.uv.x, view.size.width - at.uv.x, at.uv.y, view.size.height - at.uv.y});
  return std::max(0.0, texels) / std::sqrt(density(at, d));
}

}  // namespace

bool set_shifts(std::span<View> views, double distance_m) {
  const auto too_near = [&](const View& view) {
    return !(kLeastSeamDistance * glm::length(view.position_m) <= distance_m);
  };
  const bool fits = std::none_of(views.begin(), views.end(), too_near);
  for (View& view : views) view.shift = fits ? view.position_m / distance_m : Vec3{0.0};
  return fits;
}

Feather::Feather(const SeamSettings& seams) : width_(portable::radians(seams.feather_deg)) {}

bool Feather::shares(std::span<const View> views, const Vec3& d, std::array<double, 6>& shares) const {
  if (!(width_ > 0.0)) return false;
  std::array<double, 6> angle{};
  double best = HUGE_VAL;
  for (std::size_t v = 0; v < views.size(); ++v) {
    angle[v] = covers(views[v], d) ? angle_between(d, views[v].forward) : HUGE_VAL;
    best = std::min(best, angle[v]);
  }
  shares = {};
  double sum = 0.0;
  int count = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!(angle[v] < best + width_)) continue;
    shares[v] = smooth(1.0 - (angle[v] - best) / width_);
    if (shares[v] > 0.0) shares[v] *= smooth(2.0 * distance_from_edge(views[v], d) / width_);
    sum += shares[v];
    count += shares[v] > 0.0 ? 1 : 0;
  }
  if (count < 2) return false;
  for (double& share : shares) share /= sum;
  return true;
}

}  // namespace cupola
