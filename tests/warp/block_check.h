// Checks a warp table against every promise that warp_table.h makes to the kernels.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/warp/warp_table.h"

namespace cupola::test {

// Fails the test, with a fatal failure, at the first promise that does not hold.
void expect_sound(const WarpTable& table);

}  // namespace cupola::test
