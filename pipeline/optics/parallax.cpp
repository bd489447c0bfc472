// Seams are where neighbours of a coarse grid of the frame's pixels have different owners.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/parallax.h"

#include <algorithm>
#include <cmath>

namespace cupola {
namespace {

constexpr int kPlaces = 256;  // of the grid along a side

// Where in the frame the view shows what lies at `distance_m` in direction `d`; false where it does not see
// it.
bool shown_at(const View& view, const Vec3& d, double distance_m, Vec3& there) {
  View eye = view;
  eye.shift = view.position_m / distance_m;
  Vec2 uv;
  if (!project(eye, d, uv)) return false;
  there = direction_at(view, uv);
  return true;
}

void look(const Rig& rig, double distance_m, const Vec3& d, int first, int second, SeamParallax& largest) {
  Vec3 a;
  Vec3 b;
  ViewSample at;
  const View& own = rig.views[static_cast<std::size_t>(first)];
  if (!shown_at(own, d, distance_m, a) || !project(own, d, at) ||
      !shown_at(rig.views[static_cast<std::size_t>(second)], d, distance_m, b)) {
    return;
  }
  const double radians = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
  if (largest.first < 0 || radians > largest.radians)
    largest = {radians, radians * std::sqrt(density(at, d)), first, second};
}

}  // namespace

SeamParallax parallax_at_seams(const Rig& rig, double distance_m) {
  const Size size = rig.frame.size;
  const Vec2 step{std::max(1.0, static_cast<double>(size.width) / kPlaces),
                  std::max(1.0, static_cast<double>(size.height) / kPlaces)};
  SeamParallax largest;
  for (double y = step.y / 2; y < size.height; y += step.y) {
    for (double x = step.x / 2; x < size.width; x += step.x) {
      DirectionAndSlope here;
      if (!ray(rig.frame, {x, y}, here)) continue;
      const int own = owner(rig.views, here.direction);
      for (const Vec2 next : {Vec2{x + step.x, y}, Vec2{x, y + step.y}}) {
        DirectionAndSlope there;
        if (own < 0 || !ray(rig.frame, next, there)) continue;
        const int other = owner(rig.views, there.direction);
        if (other < 0 || other == own) continue;
        look(rig, distance_m, glm::normalize(here.direction + there.direction), own, other, largest);
      }
    }
  }
  return largest;
}

}  // namespace cupola
