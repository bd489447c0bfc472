// What `--stats` says of work that was left out, and why.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "pipeline/warp/frame_warp.h"

namespace cupola {

// Adds tiles_warped, tiles_skipped and, by reason, the table `skipped`. `texels_unneeded`: of the faces that
// were fetched, those that no pixel needs; `pictures_repeated`: those that were not decoded, being the ones
// before.
void report_skips(const WarpWork& tiles, std::int64_t texels_unneeded, std::int64_t pictures_repeated,
                  nlohmann::ordered_json& stats);

}  // namespace cupola
