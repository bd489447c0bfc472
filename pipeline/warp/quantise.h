// Real weights to integer ones with an exact sum.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/warp/tap.h"

namespace cupola {

// Integer weights for `taps` (whose weights sum to 1 and may be negative) that sum to exactly `total`, none
// above `most` and each within 1 of its real value. What is off sums to at most 1 over a checkerboard of
// texels with signs, to 2 over stripes: the texels of even and odd columns and rows are rounded each by
// themselves. By largest remainder; more than 64 taps of few steps each by carrying the rounding error on
// from tap to tap, so that wide flat footprints, whose every weight may be below 1, keep their shape. False
// when a weight exceeds `most` by more than the one step that the next heaviest tap can take over.
bool quantise(std::span<const Tap> taps, int total, int most, std::vector<int>& weights);

}  // namespace cupola
