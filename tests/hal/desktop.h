// A desktop for tests: an X server without a screen, for this process only.
// SPDX-License-Identifier: MIT
#pragma once

#include <sys/types.h>

namespace cupola {

// Starts Xvfb and points DISPLAY and SDL at it.
class Desktop {
 public:
  Desktop();  // throws std::runtime_error where Xvfb does not start
  ~Desktop();
  Desktop(const Desktop&) = delete;
  Desktop& operator=(const Desktop&) = delete;

 private:
  pid_t server_ = -1;
};

}  // namespace cupola
