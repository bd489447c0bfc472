// What a plan's taps touch.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/pyramid_plan.h"

namespace cupola {

std::vector<NeededRegion> regions_used(const PyramidShape& shape, const TapRuns& taps) {
  std::vector<NeededRegion> regions;
  for (const PyramidLevel& level : shape.levels) {
    for (const Size& size : level.sizes) regions.push_back(NeededRegion::none(size));
  }
  for (const TapRuns::Run& run : taps.runs) {
    regions[run.image].include(run.x, run.y);
    regions[run.image].include(run.x + run.count - 1, run.y);
  }
  return regions;
}

}  // namespace cupola
