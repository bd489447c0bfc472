// Meridians and parallels with their labels: what operators measure a dome with.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/source/lettering.h"

namespace cupola {

struct Horizontal {
  double azimuth;    // radians clockwise from the front, -pi to pi
  double elevation;  // radians
};
Horizontal horizontal(const Vec3& d);

// From 0 to 1, how much of a line `half_width` to either side covers a point at `distance`; radians. The edge
// is half a texel of a 1024 face soft, so that few samples resolve it.
double line_coverage(double distance, double half_width);

struct GraticuleLines {
  double minor = 0.0;  // every 10 degrees
  double major = 0.0;  // every 30 degrees
  double first = 0.0;  // the horizon and the meridian of the front
};
// Lines keep their angular width from horizon to zenith; minor meridians end at 80 degrees.
GraticuleLines graticule(const Vec3& d, const Horizontal& at);

// Azimuths along the horizon and elevations up the meridians 0, 90, 180 and 270, every 30 degrees.
std::vector<Label> graticule_labels(double height_deg);

}  // namespace cupola
