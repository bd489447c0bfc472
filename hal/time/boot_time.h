// Stamps of CLOCK_BOOTTIME, which goes on while the machine sleeps, on the clock that everything else uses.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <string>

namespace cupola {

// How long the machine has slept since it booted: CLOCK_BOOTTIME less CLOCK_MONOTONIC.
std::chrono::nanoseconds time_asleep() noexcept;

// CLOCK_BOOTTIME: since the machine was started, sleep included.
std::chrono::nanoseconds time_since_boot() noexcept;
// What this start of the machine is called by the kernel; empty where it does not say.
std::string boot_id();

// A past event's stamp on CLOCK_MONOTONIC, whichever of the two clocks it was taken by: nothing past is later
// than `now` (CLOCK_MONOTONIC), so a stamp that is was taken by CLOCK_BOOTTIME. A machine that slept for less
// than the event's age leaves its stamp as it is: late by that sleep at most.
constexpr std::chrono::nanoseconds monotonic_stamp(std::chrono::nanoseconds stamp,
                                                   std::chrono::nanoseconds now,
                                                   std::chrono::nanoseconds asleep) noexcept {
  return stamp > now && asleep > std::chrono::nanoseconds(0) ? stamp - asleep : stamp;
}

}  // namespace cupola
