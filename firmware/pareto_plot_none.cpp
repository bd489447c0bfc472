// No plots without cairo.
// SPDX-License-Identifier: MIT
#include "firmware/pareto.h"

namespace cupola {

bool draw_pareto(std::span<const ParetoPanel>, const std::filesystem::path&) {
  return false;
}

}  // namespace cupola
