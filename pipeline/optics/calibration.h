// OpenCV calibration files: a camera's real lens in place of a perfect pinhole.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/optics/view.h"

namespace cupola {

// Fills focal, principal, distortion, coefficients and limit of `view` from a YAML file as OpenCV writes
// them, with image_width, image_height, camera_matrix and distortion_coefficients (4, 5 or 8 numbers k1 k2 p1
// p2 [k3 [k4 k5 k6]]; or, with `distortion_model: fisheye`, 4 numbers). OpenCV's pixel centres are whole
// numbers, ours halves; that is allowed for. Pictures of another size are taken as the same view, resized.
// Throws InputError, also where the model folds within the picture.
void read_calibration(const std::filesystem::path& file, View& view);

// Sets view.limit to where the distortion model stops rising and says what is wrong with it, empty when
// nothing is: the picture's corners must lie before that.
std::string limit_distortion(View& view);

}  // namespace cupola
