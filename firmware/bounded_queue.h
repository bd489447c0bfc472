// Things on their way from any thread to one: a bounded ring without locks.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <optional>

namespace cupola {

// Any number of threads push, one takes; nobody waits or allocates. After Dmitry Vyukov's bounded queue: a
// slot's turn says who may use it next. Turn `n` of slot n % kSlots: free for the push number n; n + 1: holds
// what that one pushed; n + kSlots: taken, free for the next. Turns are handed over with release and acquire,
// so that what a slot holds is whole when it is read.
template <class Thing, std::size_t Slots>
class BoundedQueue {
 public:
  static constexpr std::size_t kSlots = Slots;

  BoundedQueue() {
    for (std::size_t i = 0; i < kSlots; ++i) slots_[i].turn.store(i, std::memory_order_relaxed);
  }
  BoundedQueue(const BoundedQueue&) = delete;
  BoundedQueue& operator=(const BoundedQueue&) = delete;

  // False when it is full: the thing is not taken.
  bool push(const Thing& thing) noexcept {
    std::size_t push = pushes_.load(std::memory_order_relaxed);
    for (;;) {
      Slot& slot = slots_[push % kSlots];
      const std::size_t turn = slot.turn.load(std::memory_order_acquire);
      if (turn == push) {
        if (!pushes_.compare_exchange_weak(push, push + 1, std::memory_order_relaxed)) continue;
        slot.thing = thing;
        slot.turn.store(push + 1, std::memory_order_release);
        return true;
      }
      if (turn < push) return false;  // still holds what was pushed a round ago
      push = pushes_.load(std::memory_order_relaxed);
    }
  }
  // The oldest; none also while that is still being written.
  std::optional<Thing> take() noexcept {
    Slot& slot = slots_[takes_ % kSlots];
    if (slot.turn.load(std::memory_order_acquire) != takes_ + 1) return std::nullopt;
    const Thing thing = slot.thing;
    slot.turn.store(takes_ + kSlots, std::memory_order_release);
    ++takes_;
    return thing;
  }

 private:
  static_assert(std::atomic<std::size_t>::is_always_lock_free);
  struct Slot {
    std::atomic<std::size_t> turn{0};
    Thing thing{};
  };
  std::array<Slot, kSlots> slots_;
  std::atomic<std::size_t> pushes_{0};
  std::size_t takes_ = 0;  // the taker's own
};

}  // namespace cupola
