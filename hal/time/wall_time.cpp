// The system's own.
// SPDX-License-Identifier: MIT
#include "hal/time/wall_time.h"

namespace cupola {

WallTime wall_time() noexcept {
  return std::chrono::system_clock::now();
}

}  // namespace cupola
