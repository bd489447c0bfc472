// CLOCK_THREAD_CPUTIME_ID.
// SPDX-License-Identifier: MIT
#include "hal/time/cpu_time.h"

#include <ctime>

namespace cupola {

std::chrono::nanoseconds thread_cpu_time() noexcept {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

}  // namespace cupola
