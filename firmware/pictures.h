// Pictures about a rig: the unfolded cube with its needed region, and the frame by views.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "pipeline/frame/image.h"
#include "pipeline/optics/frame_map.h"
#include "pipeline/optics/needed_region.h"
#include "pipeline/optics/rig.h"

namespace cupola {

// The faces unfolded (Greene & Heckbert 1986, figure 3): a cross where the views are those of the cube, else
// in a row. Texels that are not needed are darkened. kRgb8; faces are planar with 8 bits.
ImageBuffer unfolded(const Rig& rig, std::span<const Image> faces, std::span<const NeededRegion> needed);

// Each pixel of the frame in its view's colour (figure 4); uncovered pixels are red. kRgb8.
ImageBuffer coloured(const FrameMap& map);

}  // namespace cupola
