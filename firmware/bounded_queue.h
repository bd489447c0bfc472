// Commands on their way from any thread to the frame loop: a bounded ring without locks.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <optional>

#include "firmware/player_command.h"

namespace cupola {

// Any number of threads push, one takes; nobody waits or allocates. After Dmitry Vyukov's bounded queue: a
// slot's turn says who may use it next. Turn `n` of slot n % kSlots: free for the push number n; n + 1: holds
// what that one pushed; n + kSlots: taken, free for the next.
class CommandQueue {
 public:
  static constexpr std::size_t kSlots = 64;

  CommandQueue();
  CommandQueue(const CommandQueue&) = delete;
  CommandQueue& operator=(const CommandQueue&) = delete;

  // False when it is full: the command is not taken.
  bool push(const PlayerCommand& command) noexcept;
  // The oldest; none also while that is still being written.
  std::optional<PlayerCommand> take() noexcept;

 private:
  struct Slot {
    std::atomic<std::size_t> turn{0};
    PlayerCommand command;
  };
  std::array<Slot, kSlots> slots_;
  std::atomic<std::size_t> pushes_{0};
  std::size_t takes_ = 0;  // the taker's own
};

}  // namespace cupola
