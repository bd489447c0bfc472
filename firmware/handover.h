// One thing at a time, from a thread that has made it to the frame loop, and back.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>

namespace cupola {

// Both sides' calls never wait or allocate. What is handed over belongs to the maker's side throughout; the
// loop uses it from take() to give_back(), which it calls before it takes the next but one.
template <class Thing>
class Handover {
 public:
  // The maker's. Puts `thing` there for the loop; returns what was there and was not taken, or null.
  Thing* offer(Thing* thing) noexcept { return offered_.exchange(thing, std::memory_order_acq_rel); }
  // What the loop gave back, or null.
  Thing* returned() noexcept { return returned_.exchange(nullptr, std::memory_order_acq_rel); }

  // The loop's. Null where there is nothing new.
  Thing* take() noexcept {
    if (!offered_.load(std::memory_order_relaxed)) return nullptr;
    return offered_.exchange(nullptr, std::memory_order_acq_rel);
  }
  void give_back(Thing* thing) noexcept { returned_.store(thing, std::memory_order_release); }

 private:
  std::atomic<Thing*> offered_{nullptr};
  std::atomic<Thing*> returned_{nullptr};
};

}  // namespace cupola
