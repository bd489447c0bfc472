// Whole numbers throughout: a double has no bits left for the fraction.
// SPDX-License-Identifier: MIT
#include "firmware/osc_time.h"

namespace cupola {

using std::chrono::nanoseconds;
using std::chrono::seconds;

namespace {

constexpr std::uint64_t kFrom1900To1970 = 2'208'988'800;  // seconds: 70 years, 17 of them leap years
constexpr std::uint64_t kNanoseconds = 1'000'000'000;     // a second's
constexpr std::uint64_t kHalf = 1U << 31U;                // of a nanosecond, before the shift
constexpr auto kSame = std::chrono::milliseconds(1);

}  // namespace

OscTime osc_time(WallTime time) {
  const auto since_1970 = std::chrono::duration_cast<nanoseconds>(time.time_since_epoch());
  const auto whole = std::chrono::floor<seconds>(since_1970);
  const auto rest = static_cast<std::uint64_t>((since_1970 - whole).count());  // below 2^30
  const std::uint64_t fraction = (rest << 32U) / kNanoseconds;
  return ((static_cast<std::uint64_t>(whole.count()) + kFrom1900To1970) << 32U) + fraction;
}

nanoseconds between(OscTime from, OscTime to) {
  const auto apart = static_cast<std::int64_t>(to - from);
  const std::int64_t whole = apart >> 32;  // -2^31 to 2^31 - 1
  const std::uint64_t fraction = static_cast<std::uint64_t>(apart) & 0xffff'ffffU;
  return seconds(whole) +
         nanoseconds((fraction * kNanoseconds + kHalf) >> 32U);  // below 2^62 before the shift
}

void OscMoments::look(WallTime day, nanoseconds clock) {
  const nanoseconds drift = (day - day_) - (clock - clock_);
  if (std::chrono::abs(drift) < kSame) return;
  day_ = day;
  clock_ = clock;
}

nanoseconds OscMoments::due(OscTime when) const {
  return when == kOscAtOnce ? clock_ : clock_ + between(osc_time(day_), when);
}

}  // namespace cupola
