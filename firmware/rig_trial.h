// `cupola check --rig`: every device of the rig is tried, and what was measured of it printed.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "firmware/rig_devices.h"
#include "pipeline/optics/rig.h"

namespace cupola {

// Streams the cameras for two seconds, takes the GPIO lines for a moment and looks for the projector's mode
// for the rig's frames, without setting it. Prints a line a device and one a seam; returns what is wrong, in
// words.
std::vector<std::string> try_rig(const Rig& rig, const RigDevices& devices);

// The first two seconds of what the cameras said in a recording, instead; no other device. Throws InputError
// where it cannot be read.
std::vector<std::string> try_recording(const Rig& rig, const RigDevices& devices,
                                       const std::filesystem::path& folder);

}  // namespace cupola
