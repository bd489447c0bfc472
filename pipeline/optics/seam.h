// Seams: where the pictures of two views overlap, how much of each is seen.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <span>

#include "pipeline/optics/view.h"

namespace cupola {

struct SeamSettings {
  double feather_deg = 0.0;      // width of the band in which two views mix; 0: views meet in a line
  double distance_m = HUGE_VAL;  // from the rig's centre, at which views from different places meet
};

// The least distance at which seams may close, in lengths of the farthest view's position: nearer, two eyes
// of a rig would look past each other. All arithmetic with shifts counts on their being at most 1 / 2.
inline constexpr double kLeastSeamDistance = 2.0;

// Every view's shift for its position. False, and no shift, where a position is too long for the distance.
bool set_shifts(std::span<View> views, double distance_m);

// A view's share at each ray, summing to 1 over the views. A view's goodness is the angle between the ray and
// its forward axis, less being better, so that views of one kind meet half-way between their axes. With e the
// angle by which view v is worse than the best view that covers the ray, m its ray's distance from the edge
// of its picture, F the feather, and s(t) = t^2 (3 - 2 t) on t clamped to [0, 1],
//
//   share(v) ~ s(1 - e / F) s(2 m / F).
//
// Across a seam between axes far apart e grows twice as fast as the distance from it: the band is F wide.
// Shares have no steps where pictures overlap: a view has lost its share when its picture ends.
class Feather {
 public:
  explicit Feather(const SeamSettings& seams);

  // Whether more than one view has a share; if so, `shares` are those of the views, up to six.
  bool shares(std::span<const View> views, const Vec3& d, std::array<double, 6>& shares) const;

 private:
  double width_;  // radians
};

}  // namespace cupola
