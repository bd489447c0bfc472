// How far apart neighbours may show the same far point, by what is known of their lenses and poses.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "pipeline/calibrate/adjustment.h"
#include "pipeline/calibrate/rig_calibration.h"

namespace cupola {

// Over directions that two views cover and whose distances from both axes differ by less than 6 degrees;
// views of size 0 x 0 cover nothing. `covariance` as Adjustment has it.
std::vector<SeamCalibration> expected_seam_errors(
    std::span<const View> views,
    const std::function<Adjustment::Block(std::size_t a, std::size_t b)>& covariance);

}  // namespace cupola
