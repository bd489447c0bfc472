// Telling a press from the bouncing that follows it.
// SPDX-License-Identifier: MIT
#include "hal/gpio/debouncer.h"

namespace cupola {

using std::chrono::nanoseconds;

void Debouncer::reset(bool active) noexcept {
  active_ = level_ = active;
  restless_ = handed_ = false;
}

void Debouncer::edge(bool active, nanoseconds at) noexcept {
  if (!restless_) first_ = at;
  restless_ = true;
  last_ = at;
  level_ = active;
}

std::optional<Debouncer::Change> Debouncer::change(nanoseconds now) noexcept {
  if (!restless_) return std::nullopt;
  const bool quiet = now - last_ >= quiet_;
  const bool at_once = kind_ == GpioDebounce::kAtOnce;
  if (level_ != active_ && (quiet || (at_once && !handed_))) {
    active_ = level_;
    restless_ = !quiet;
    handed_ = !quiet;
    return Change{active_, at_once ? last_ : first_};
  }
  if (quiet) restless_ = handed_ = false;
  return std::nullopt;
}

nanoseconds Debouncer::deadline() const noexcept {
  return restless_ ? last_ + quiet_ : nanoseconds::max();
}

}  // namespace cupola
