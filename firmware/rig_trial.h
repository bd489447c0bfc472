// `cupola check --rig`: every device of the rig is tried, and what was measured of it printed.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "firmware/rig_devices.h"
#include "pipeline/frame/image.h"

namespace cupola {

// Streams the cameras for two seconds, takes the GPIO lines for a moment and looks for the projector's mode
// for frames of `frame`, without setting it. Prints a line a device; returns what is wrong, in words.
std::vector<std::string> try_rig(const RigDevices& devices, Size frame);

}  // namespace cupola
