// Cameras that send a part of the picture agreed on: which texels of it.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "hal/camera/camera.h"
#include "pipeline/optics/view.h"

namespace cupola {

// Where frames of mode `part` lie in the picture of mode `whole`, texel on texel: the same scale, whole
// texels apart and chroma on chroma. None where they are anything else. A whole of which no crop is known
// (width 0) has no parts.
std::optional<TexelBox> place_of(const CameraMode& part, const CameraMode& whole);

// The area of the sensor that shows texels `box` of the picture of mode `whole`, rounded outwards.
CameraArea area_of(const TexelBox& box, const CameraMode& whole);

inline bool contains(const TexelBox& box, const TexelBox& inner) {
  return inner.empty() ||
         (box.x0 <= inner.x0 && box.y0 <= inner.y0 && inner.x1 <= box.x1 && inner.y1 <= box.y1);
}

}  // namespace cupola
