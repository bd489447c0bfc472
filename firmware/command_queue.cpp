// Turns are handed over with release and acquire, so that a slot's command is whole when it is read.
// SPDX-License-Identifier: MIT
#include "firmware/command_queue.h"

namespace cupola {

static_assert(std::atomic<std::size_t>::is_always_lock_free);

CommandQueue::CommandQueue() {
  for (std::size_t i = 0; i < kSlots; ++i) slots_[i].turn.store(i, std::memory_order_relaxed);
}

bool CommandQueue::push(const PlayerCommand& command) noexcept {
  std::size_t push = pushes_.load(std::memory_order_relaxed);
  for (;;) {
    Slot& slot = slots_[push % kSlots];
    const std::size_t turn = slot.turn.load(std::memory_order_acquire);
    if (turn == push) {
      if (!pushes_.compare_exchange_weak(push, push + 1, std::memory_order_relaxed)) continue;
      slot.command = command;
      slot.turn.store(push + 1, std::memory_order_release);
      return true;
    }
    if (turn < push) return false;  // still holds what was pushed a round ago
    push = pushes_.load(std::memory_order_relaxed);
  }
}

std::optional<PlayerCommand> CommandQueue::take() noexcept {
  Slot& slot = slots_[takes_ % kSlots];
  if (slot.turn.load(std::memory_order_acquire) != takes_ + 1) return std::nullopt;
  const PlayerCommand command = slot.command;
  slot.turn.store(takes_ + kSlots, std::memory_order_release);
  ++takes_;
  return command;
}

}  // namespace cupola
