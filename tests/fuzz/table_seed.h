// The rig whose table files are fuzzed.
// SPDX-License-Identifier: MIT
#pragma once

#include "tests/warp/faces.h"

namespace cupola {

// Small, yet with seams, an uncovered part and both narrow and wide blocks in its table.
inline Rig table_fuzz_rig() {
  Rig rig = test::omnimax_rig({24, 18}, 24, {40, 40}, {"front", "left", "top"});
  rig.filter.radius = 2.0;
  return rig;
}

}  // namespace cupola
