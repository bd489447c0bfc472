// CLOCK_BOOTTIME.
// SPDX-License-Identifier: MIT
#include "hal/time/boot_time.h"

#include <ctime>
#include <fstream>

namespace cupola {

namespace {

std::chrono::nanoseconds read_clock(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace

std::chrono::nanoseconds time_since_boot() noexcept {
  return read_clock(CLOCK_BOOTTIME);
}

std::string boot_id() {
  std::ifstream in("/proc/sys/kernel/random/boot_id");
  std::string id;
  std::getline(in, id);
  return id;
}

std::chrono::nanoseconds time_asleep() noexcept {
  // Read in this order, the time between the readings can only make the answer smaller.
  const std::chrono::nanoseconds with_sleep = read_clock(CLOCK_BOOTTIME);
  return with_sleep - read_clock(CLOCK_MONOTONIC);
}

}  // namespace cupola
