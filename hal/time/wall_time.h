// The time of day, for people who read logs. Nothing else goes by it: it jumps.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>

namespace cupola {

using WallTime = std::chrono::system_clock::time_point;

WallTime wall_time() noexcept;

}  // namespace cupola
