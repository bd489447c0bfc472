// Work beside the frame loop, for which the loop only rings.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace cupola {

// To be made before the frame loop's thread gets a priority of its own, which would be inherited.
class SideWork {
 public:
  // `work` is called once or more after each ring, and must not throw. `lowest`: of the lowest priority, and
  // so are the threads that it begins.
  explicit SideWork(std::function<void()> work, bool lowest = true);
  ~SideWork() { finish(); }
  SideWork(const SideWork&) = delete;
  SideWork& operator=(const SideWork&) = delete;

  // Any thread; neither waits nor allocates.
  void ring() noexcept;
  // Returns when the work in hand is done; no more is begun.
  void finish();
  bool stopping() const noexcept { return stopping_.load(std::memory_order_relaxed); }

 private:
  std::function<void()> work_;
  std::atomic<int> bell_{0};
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace cupola
