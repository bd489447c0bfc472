// Cones and planes through the eye.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/view_region.h"

#include <algorithm>
#include <cmath>

namespace cupola {

Cone cone_of_box(const View& home, const Vec3& direction, const ViewSample& at, double half_width,
                 double half_height) {
  if (home.distortion == Distortion::kNone) {
    double least = 1.0;
    for (const double u : {at.uv.x - half_width, at.uv.x + half_width}) {
      for (const double v : {at.uv.y - half_height, at.uv.y + half_height}) {
        least = std::min(least, glm::dot(direction, direction_at(home, {u, v})));
      }
    }
    // A cone is convex in the plane, so that its corners speak for the box; from an eye beside the centre,
    // while that is not within the cone's cap.
    if (least <= glm::length(home.shift)) least = kFarthestCosine;
    least = std::max(least, kFarthestCosine);
    return {std::sqrt((1.0 - least) * (1.0 + least)) + 1e-8, least};
  }
  // Texels a radian in the direction where they are fewest; the angle is doubled, since the model bends.
  const double uu = glm::dot(at.du, at.du);
  const double vv = glm::dot(at.dv, at.dv);
  const double uv = glm::dot(at.du, at.dv);
  const double half = (uu - vv) / 2;
  const double fewest = std::sqrt(std::max(1e-12, (uu + vv) / 2 - std::sqrt(half * half + uv * uv)));
  return portable::sine_cosine(
      std::min(2.0 * std::sqrt(half_width * half_width + half_height * half_height) / fewest, kFarthest));
}

bool owns_whole_box(std::span<const View> views, int home, const Vec3& direction, const PlaneBox& box,
                    const Cone& cone) {
  const View& own = views[static_cast<std::size_t>(home)];
  if (box.u - box.half_width < 0.0 || box.v - box.half_height < 0.0 ||
      box.u + box.half_width > own.size.width || box.v + box.half_height > own.size.height) {
    return false;
  }
  if (cone.cosine <= kFarthestCosine) return false;
  // A view is nearer than another on one side of a plane through the eye, with normal n = forward - other
  // forward. Directions within the angle a of d reach down to d.n cos a - |n| sin a.
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (static_cast<int>(i) == home) continue;
    const Vec3 n = own.forward - views[i].forward;
    if (glm::dot(direction, n) * cone.cosine - glm::length(n) * cone.sine <= 1e-9) return false;
  }
  return true;
}

}  // namespace cupola
