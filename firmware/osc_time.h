// OSC's time tags: NTP's time of day, 2^-32 seconds since 1900; begins anew every 136 years, next in 2036.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>

#include "hal/time/wall_time.h"

namespace cupola {

using OscTime = std::uint64_t;

constexpr OscTime kOscAtOnce = 1;

OscTime osc_time(WallTime time);

// Of times that are at most 68 years apart, as the count begins anew.
constexpr bool earlier(OscTime one, OscTime other) {
  return static_cast<std::int64_t>(one - other) < 0;
}
// To the nearest nanosecond; negative where `to` is earlier. Of such times too.
std::chrono::nanoseconds between(OscTime from, OscTime to);

// Where OSC's times are on the clock that everything else goes by. Not for threads at once.
class OscMoments {
 public:
  // Both read as close together as can be. What agrees with the readings before to a millisecond changes
  // nothing, so that equal times are the same moment and others keep their order; where the time of day has
  // jumped it counts from now on.
  void look(WallTime day, std::chrono::nanoseconds clock);
  // For times of 68 years before or after the readings. At once is when the clocks were read.
  std::chrono::nanoseconds due(OscTime when) const;

 private:
  WallTime day_{};
  std::chrono::nanoseconds clock_{0};
};

}  // namespace cupola
