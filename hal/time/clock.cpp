// The machine's monotonic clock.
// SPDX-License-Identifier: MIT
#include "hal/time/clock.h"

#include <cerrno>
#include <ctime>

namespace cupola {

std::chrono::nanoseconds MonotonicClock::now() noexcept {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

void MonotonicClock::sleep_until(std::chrono::nanoseconds deadline) noexcept {
  if (deadline <= std::chrono::nanoseconds(0)) return;
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(deadline);
  timespec until{};
  until.tv_sec = seconds.count();
  until.tv_nsec = (deadline - seconds).count();
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace cupola
