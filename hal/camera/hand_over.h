// Small numbers from one thread to another: a ring of fixed size, and a descriptor to wait for.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <optional>

namespace cupola {

// One thread pushes, one other pops; neither waits for the other, and nothing allocates.
class HandOver {
 public:
  static constexpr std::size_t kCapacity = 64;

  HandOver() noexcept;  // descriptor() is -1 when the system has no descriptors left
  ~HandOver();
  HandOver(const HandOver&) = delete;
  HandOver& operator=(const HandOver&) = delete;

  bool push(int value) noexcept;      // false: it is full, and the value is gone
  std::optional<int> pop() noexcept;  // the oldest
  int wait() noexcept;                // the same, once there is one
  // Any thread: makes the descriptor readable without a value.
  void wake() noexcept;
  // Can be read when there is a value or a wake-up; pop() takes it back.
  int descriptor() const noexcept { return descriptor_; }

 private:
  int descriptor_;  // an eventfd that counts values and wake-ups, so never less than the ring holds
  std::array<int, kCapacity> ring_{};
  alignas(64) std::atomic<std::size_t> pushed_{0};
  alignas(64) std::atomic<std::size_t> popped_{0};
};

}  // namespace cupola
