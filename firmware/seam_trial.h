// What check says of a rig's seams, from the pictures of its cameras' trial.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <span>
#include <string>
#include <vector>

#include "firmware/camera_trial.h"
#include "firmware/open_cameras.h"
#include "pipeline/optics/rig.h"

namespace cupola {

// Prints a line for every two views that overlap: how far apart they show the same things. Pictures whose
// timestamps differ by no more than `tolerance` are of one instant. One result a camera. Returns what is
// wrong, in words.
std::vector<std::string> try_seams(const Rig& rig, std::span<const OpenCamera> cameras,
                                   std::span<const TrialResult> results, std::chrono::nanoseconds tolerance);

}  // namespace cupola
