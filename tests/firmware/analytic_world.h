// A world of which everything is known, and how far a dome frame is from it.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/optics/rig.h"

namespace cupola {

inline constexpr int kDomeSide = 360;  // of the frame: a pixel is half a degree

// A smooth sky with 97 marks on it: bright spots with a half width of 1.2 degrees. 0 to 255.
std::vector<Vec3> marks();
Vec3 world(const Vec3& d, const std::vector<Vec3>& places);

struct DomeError {
  double mark = 0.0;    // pixels, the most any mark is off
  double smooth = 0.0;  // steps of 255, the most where there is no mark
  double rms = 0.0;     // there
  int marks = 0;
  int pixels = 0;
};

// A dome frame of the world against the world itself; where the views see it.
DomeError dome_error(const ImageBuffer& frame, const Rig& rig);

}  // namespace cupola
