// A rig's controls, in the words of a V4L2 driver.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include "hal/camera/v4l2_node.h"

namespace cupola {

// Automatics first, as drivers refuse values that are set by one; then in the order given. "gain" needs a
// driver whose gain begins above 0, which is then 1; "trigger" is the driver's first control with that word
// in its name, as V4L2 has none of its own. Other names are the driver's ("Gain, Red") or v4l2-ctl's way of
// writing them ("gain_red").
std::optional<CameraTrouble> set_controls(const V4l2Node& node, std::span<const CameraControl> controls);

// One of them, to the nearest value that the driver has; false where there is no such control, or it does not
// take that.
bool set_nearest_control(const V4l2Node& node, const CameraControl& control);

}  // namespace cupola
