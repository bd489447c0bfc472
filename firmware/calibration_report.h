// What a calibration found, as a table for the crew and as JSON.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "pipeline/calibrate/rig_calibration.h"

namespace cupola {

// `rig` as it was before; `shots` are their names.
std::string calibration_table(const RigCalibration& calibration, const Rig& rig,
                              std::span<const std::string> shots);
std::string calibration_json(const RigCalibration& calibration, const Rig& rig,
                             std::span<const std::string> shots);

}  // namespace cupola
