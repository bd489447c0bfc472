// One table for all commands.
// SPDX-License-Identifier: MIT
#include "firmware/skip_report.h"

namespace cupola {

void report_skips(const WarpWork& tiles, std::int64_t texels_unneeded, std::int64_t pictures_repeated,
                  nlohmann::ordered_json& stats) {
  stats["tiles_warped"] = tiles.pieces;
  stats["tiles_skipped"] = tiles.skipped + tiles.even + tiles.outside;
  stats["skipped"] = {{"tiles_unchanged", tiles.skipped},
                      {"tiles_even", tiles.even},
                      {"tiles_outside", tiles.outside},
                      {"face_texels_unneeded", texels_unneeded},
                      {"pictures_repeated", pictures_repeated}};
}

}  // namespace cupola
