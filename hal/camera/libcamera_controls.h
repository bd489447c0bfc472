// What a setup asks for beside format and size, in libcamera's controls.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "hal/camera/camera.h"
#include "hal/camera/libcamera_version.h"

namespace cupola {

// ScalerCrop enlarges what it leaves to the stream's size. The size that leaves the sensor's texels as large
// as they are in the whole picture, of mode `whole`; x and y are 0. None where the setup wants no crop, or
// the camera cannot.
std::optional<CameraArea> size_of_crop(const CameraSetup& setup, const libcamera::Camera& camera,
                                       const CameraMode& whole);

// Fills `controls` from the setup's rate, crop and controls, for a camera that is configured, and `mode` with
// the rate and crop that come of it. Beside the names of CameraControl: "ColourGains.red" and ".blue".
std::optional<CameraTrouble> set_controls(const CameraSetup& setup, const libcamera::Camera& camera,
                                          libcamera::ControlList& controls, CameraMode& mode);

// One of Camera::set_control(), for a camera that streams; false where it has none or does not take the
// value.
bool set_control(const CameraControl& control, const libcamera::Camera& camera,
                 libcamera::ControlList& controls);

}  // namespace cupola
