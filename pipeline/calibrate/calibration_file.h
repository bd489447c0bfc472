// A calibrated lens as OpenCV would write it, for read_calibration and for everything else that reads these
// files.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "pipeline/optics/view.h"

namespace cupola {

// `rms` in texels; OpenCV calls it avg_reprojection_error.
std::string calibration_text(const View& view, double rms);

}  // namespace cupola
