// Things that are to count later: bounded, in the order of their times.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

namespace cupola {

// One thread's own.
template <class Thing, std::size_t Slots>
class DueQueue {
 public:
  static constexpr std::size_t kSlots = Slots;

  std::size_t room() const noexcept { return kSlots - things_.size(); }
  // When the first one is due; nanoseconds::max() where there is none.
  std::chrono::nanoseconds next() const noexcept {
    return things_.empty() ? std::chrono::nanoseconds::max() : things_.begin()->first;
  }
  // False when it is full: the thing is not taken.
  bool add(std::chrono::nanoseconds due, Thing thing) {
    if (room() == 0) return false;
    things_.emplace(due, std::move(thing));  // behind those of the same time
    return true;
  }
  // The first one, if it is due.
  std::optional<Thing> take(std::chrono::nanoseconds now) {
    if (things_.empty() || now < next()) return std::nullopt;
    return std::move(things_.extract(things_.begin()).mapped());
  }

 private:
  std::multimap<std::chrono::nanoseconds, Thing> things_;
};

}  // namespace cupola
