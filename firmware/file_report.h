// What --stats and the status say of pictures that are read from files while the show plays.
// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>

#include "pipeline/source/face_streams.h"

namespace cupola {

nlohmann::ordered_json describe(const FileCounts& counts);

}  // namespace cupola
