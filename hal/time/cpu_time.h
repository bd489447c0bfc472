// Processor time, for measuring work where other programs share the machine.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>

namespace cupola {

// What the calling thread has used so far.
std::chrono::nanoseconds thread_cpu_time() noexcept;

}  // namespace cupola
