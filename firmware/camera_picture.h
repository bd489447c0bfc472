// What one picture of a camera says of its focus and its exposure.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "hal/camera/camera.h"
#include "pipeline/frame/grey_picture.h"

namespace cupola {

struct PictureFacts {
  // Of the sharpest tenth of the picture's edges, the widest: their height over their steepest texel, which
  // is about the way from a tenth to nine tenths. 0 where there are too few edges to say.
  double edge_texels = 0.0;
  double mean = 0.0;         // share of white
  double white_share = 0.0;  // of the texels that are as bright as the format goes
};

// From every fourth row's brightness; of RGB, its green. None for JPEG pictures and damaged frames.
std::optional<PictureFacts> look_at(const CameraFrame& frame, const CameraMode& mode);

// All of the same brightness, copied; none for the same.
std::optional<GreyPicture> grey_of(const CameraFrame& frame);

}  // namespace cupola
