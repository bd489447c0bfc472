// How many planes, rows and bytes a picture of a format has.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "hal/camera/camera.h"

namespace cupola {

struct PlaneShape {
  std::ptrdiff_t row_bytes = 0;  // of texels: the least stride
  int rows = 0;
};

int plane_count(CameraFormat format);
// Zero for kMjpeg and for planes that the format has not.
PlaneShape plane_shape(CameraFormat format, int plane, int width, int height);

// Whether the frame is what the mode says, with strides that hold its rows.
bool fits(const CameraFrame& frame, const CameraMode& mode);
// Whether every plane has the bytes of all its rows; of kMjpeg, any at all.
bool is_whole(const CameraFrame& frame);

}  // namespace cupola
