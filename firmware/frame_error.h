// How far a fixed-point frame is from the unrounded reference.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/optics/frame_map.h"

namespace cupola {

// In 8-bit steps, over all channels of the pixels that some view covers.
struct FrameError {
  double rms = 0.0;
  double max = 0.0;
};

// `frame` is kRgbPlanar8; `exact` as ewa_exact_frame gives it.
FrameError frame_error(const FrameMap& map, const Image& frame, const std::vector<double>& exact);

// Faces of even noise for every view, the hardest picture for fixed-point weights.
std::vector<ImageBuffer> noise_faces(const Rig& rig);

}  // namespace cupola
