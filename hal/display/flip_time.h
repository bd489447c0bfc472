// When a screen flips: a raster of times that the last flip began.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace cupola {

// The first flip after `last` that is not before `now` and not more than a sixteenth of a period before
// `when`.
inline std::chrono::nanoseconds next_flip(std::chrono::nanoseconds last, std::chrono::nanoseconds period,
                                          std::chrono::nanoseconds when,
                                          std::chrono::nanoseconds now) noexcept {
  const std::chrono::nanoseconds wait = std::max(when - period / 16, now) - last;
  return last + std::max<std::int64_t>(1, (wait + period - std::chrono::nanoseconds(1)) / period) * period;
}

}  // namespace cupola
