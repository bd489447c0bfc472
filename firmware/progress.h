// A progress bar, on a terminal only.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "hal/time/clock.h"

namespace cupola {

// Draws on standard error, a few times a second; wiped when it goes.
class Progress {
 public:
  Progress(std::string what, std::int64_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void show(std::int64_t done);

 private:
  std::string what_;
  std::int64_t total_;
  bool on_terminal_;
  MonotonicClock clock_;
  std::chrono::nanoseconds next_{0};
};

}  // namespace cupola
