// One input's edges, without the bouncing of its contacts.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <optional>

#include "hal/gpio/gpio.h"

namespace cupola {

// A pure function of the edges it is told and the times it is asked at, which must not run backwards.
class Debouncer {
 public:
  struct Change {
    bool active = false;
    std::chrono::nanoseconds at{0};  // of the edge that began it
  };

  Debouncer(std::chrono::nanoseconds quiet, GpioDebounce kind) : quiet_(quiet), kind_(kind) {}

  // The line is `active`, whatever it was before.
  void reset(bool active) noexcept;
  // First ask for the change at `at`, until there is none.
  void edge(bool active, std::chrono::nanoseconds at) noexcept;
  // What is certain at `now` and was not handed out yet.
  std::optional<Change> change(std::chrono::nanoseconds now) noexcept;
  // When change() has something to decide, if no edge comes before; max(): never.
  std::chrono::nanoseconds deadline() const noexcept;
  bool active() const noexcept { return active_; }

 private:
  std::chrono::nanoseconds quiet_;
  GpioDebounce kind_;
  bool active_ = false;                // as handed out
  bool level_ = false;                 // of the line
  bool restless_ = false;              // an edge came less than quiet_ ago
  bool handed_ = false;                // kAtOnce: and a change since then, whose bouncing this is
  std::chrono::nanoseconds first_{0};  // edge of the restlessness
  std::chrono::nanoseconds last_{0};
};

}  // namespace cupola
