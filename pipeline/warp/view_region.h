// Which views feed the directions about a pixel's ray, and all their texels there.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/optics/view.h"
#include "pipeline/portable/portable_math.h"
#include "pipeline/warp/tap.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {

// A box of a view's plane about (u, v), texels.
struct PlaneBox {
  double u, v;
  double half_width, half_height;
};

using Cone = portable::SineCosine;  // of its half angle

// A cone about `direction`, which projects to `at` in the middle of the box, that holds all of the box.
Cone cone_of_box(const View& home, const Vec3& direction, const ViewSample& at, double half_width,
                 double half_height);

// Whether `home` alone feeds all directions of the box, which lie within `cone` of `direction`.
bool owns_whole_box(std::span<const View> views, int home, const Vec3& direction, const PlaneBox& box,
                    const Cone& cone);

// Adds every texel of every view whose centre that view owns and has weight(du, dv) != 0 where it falls in
// the plane of `home`, less (u, v). Texels of other views weigh as many times more as they are fewer there.
// Stops past kMostTaps.
template <class Weight>
void gather_near(std::span<const View> views, int home, const Vec3& direction, double u, double v,
                 double angle, const Weight& weight, std::vector<Tap>& taps) {
  const View& plane = views[static_cast<std::size_t>(home)];
  for (std::size_t i = 0; i < views.size(); ++i) {
    const View& own = views[i];
    const TexelBox box = texels_near(own, direction, angle);
    for (int y = box.y0; y < box.y1 && taps.size() <= kMostTaps; ++y) {
      for (int x = box.x0; x < box.x1; ++x) {
        const Vec3 d = direction_at(own, {x + 0.5, y + 0.5});
        ViewSample in_plane;
        if (glm::dot(d, direction) <= kFarthestCosine || !project(plane, d, in_plane)) continue;
        const bool at_home = static_cast<int>(i) == home;
        double share =
            weight((at_home ? x + 0.5 : in_plane.uv.x) - u, (at_home ? y + 0.5 : in_plane.uv.y) - v);
        if (share == 0.0 || owner(views, d) != static_cast<int>(i)) continue;
        if (!at_home) {
          ViewSample in_own;
          project(own, d, in_own);
          share *= density(in_plane, d) / density(in_own, d);
        }
        taps.push_back({x, y, static_cast<int>(i), share});
      }
    }
  }
}

}  // namespace cupola
