// The frontier of time against error.
// SPDX-License-Identifier: MIT
#include "firmware/pareto.h"

#include <algorithm>
#include <limits>

namespace cupola {

void find_frontier(std::vector<ParetoMark>& marks) {
  std::vector<ParetoMark*> by_time;
  for (ParetoMark& mark : marks) {
    mark.frontier = false;
    if (!mark.peer) by_time.push_back(&mark);
  }
  std::sort(by_time.begin(), by_time.end(), [](const ParetoMark* a, const ParetoMark* b) {
    return a->ns_per_pixel != b->ns_per_pixel ? a->ns_per_pixel < b->ns_per_pixel : a->error < b->error;
  });
  double least = std::numeric_limits<double>::infinity();
  for (ParetoMark* mark : by_time) {
    if (mark->error >= least) continue;
    least = mark->error;
    mark->frontier = true;
  }
}

}  // namespace cupola
