// What a plan's taps touch.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/pyramid_plan.h"

namespace cupola {

std::vector<TexelSpans> texels_used(const PyramidShape& shape, const TapRuns& taps) {
  std::vector<TexelSpans> used;
  for (const PyramidLevel& level : shape.levels) {
    for (const Size& size : level.sizes) used.push_back(TexelSpans::none(size));
  }
  for (const TapRuns::Run& run : taps.runs) used[run.image].add(run.y, {run.x, run.x + run.count});
  return used;
}

}  // namespace cupola
