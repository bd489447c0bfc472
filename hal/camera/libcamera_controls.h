// What a setup asks for beside format and size, in libcamera's controls.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "hal/camera/camera.h"
#include "hal/camera/libcamera_version.h"

namespace cupola {

// Fills `controls` from the setup's rate, crop and controls, for a camera that is configured, and `mode` with
// the rate and crop that come of it. Beside the names of CameraControl: "ColourGains.red" and ".blue".
std::optional<CameraTrouble> set_controls(const CameraSetup& setup, const libcamera::Camera& camera,
                                          libcamera::ControlList& controls, CameraMode& mode);

}  // namespace cupola
