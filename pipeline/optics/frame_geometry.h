// Frame models: which ray each output pixel looks along, and how the ray turns from pixel to pixel.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/optics/lens.h"
#include "pipeline/optics/vector.h"
#include "pipeline/optics/view.h"

namespace cupola {

enum class FrameModel : std::uint8_t {
  kFisheye,          // through `lens`
  kEquirectangular,  // longitude across, latitude up, both linear
  kCylindrical,      // longitude across, tan(latitude) up
  kMercator,         // longitude across, ln tan(pi / 4 + latitude / 2) up
  kChromeBall,       // the surroundings mirrored in a ball, seen from far away behind, looking along -z
  kCube,             // an atlas of perspective views
};

enum class Crop : std::uint8_t {
  kNone,
  kOmnimax,  // rays below the plane 45 degrees under the axis, d.y < d.z, are outside the image
};

struct FrameGeometry {
  FrameModel model = FrameModel::kFisheye;
  Size size;            // pixels
  Vec2 center;          // kFisheye, kChromeBall: pixels
  double radius = 0.0;  // kFisheye, kChromeBall: pixels; r = 1
  Crop crop = Crop::kNone;
  Lens lens;                // kFisheye
  double fov = 0.0;         // the three maps of the world: longitude across the whole width, radians
  int columns = 1;          // kCube: faces in a row of the atlas
  std::vector<View> faces;  // kCube: row by row; their sizes are those of the atlas's cells
};

// The ray of the point `p` (pixels) in lens space with its derivatives by p, or false outside the image.
bool ray(const FrameGeometry& frame, const Vec2& p, DirectionAndSlope& ray);

}  // namespace cupola
