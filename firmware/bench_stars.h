// The star test: how much a point of light flickers as it drifts over the pixels.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "firmware/bench_warp.h"

namespace cupola {

// Stars are single texels, sixteen apart, on an even ground that moves under the frame in ten steps of a
// tenth of a pixel, aslant. A star's energy is what it adds to the pixels about it; a perfect filter keeps
// it.
struct StarRow {
  std::string contender;
  int ground = 0;               // per cent; on black, what would be darker than black is cut off
  double mean_variation = 0.0;  // standard deviation over mean of a star's energy, averaged over stars
  double worst_swing = 0.0;     // largest less smallest energy over mean, of the worst star
  int never_lit = 0;            // stars that fell between all pixels, in neither of these
};

// Faces of circle * 512 / 983 texels a side; a row for every contender and ground, with the peers' at the end
// where there are any.
std::vector<StarRow> measure_stars(const std::vector<Contender>& contenders, int circle, WorkerPool& pool);

// The filters worth comparing.
std::vector<Contender> star_contenders();

}  // namespace cupola
