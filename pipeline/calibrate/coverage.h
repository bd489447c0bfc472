// Where in a camera's picture the board was never seen.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "pipeline/calibrate/sighting.h"
#include "pipeline/frame/image.h"

namespace cupola {

// Of the picture's nine parts, those without a corner, in words: "the left third", "the upper left corner".
std::vector<std::string> parts_without_board(std::span<const Sighting* const> sightings, Size size);

}  // namespace cupola
