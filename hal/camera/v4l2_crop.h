// Which part of the sensor's picture a V4L2 device sends.
// SPDX-License-Identifier: MIT
#pragma once

#include "hal/camera/v4l2_node.h"

namespace cupola {

struct V4l2Whole {
  CameraArea area;  // of the sensor; width 0: the device does not tell
  int left = 0;     // where the sensor's picture begins in the driver's coordinates
  int top = 0;
};

// Ends an earlier crop, which drivers keep. Devices that cannot crop are left as they are.
V4l2Whole uncrop(const V4l2Node& node) noexcept;
// Crops to the smallest area the device can that holds `area`, which becomes it. False: it cannot, or `area`
// has nothing of the picture.
bool set_crop(const V4l2Node& node, const V4l2Whole& whole, CameraArea& area) noexcept;
// What frames of that mode show.
CameraArea crop_of(const V4l2Node& node, const CameraMode& mode) noexcept;

}  // namespace cupola
