// The queue between threads: nothing lost, nothing twice, each thread's order kept.
// SPDX-License-Identifier: MIT
#include "firmware/command_queue.h"

#include <gtest/gtest.h>

#include <array>
#include <thread>
#include <vector>

namespace cupola {
namespace {

PlayerCommand numbered(std::int64_t number, std::size_t from = 0) {
  return {PlayerAction::kSeek, std::chrono::nanoseconds(number), from};
}

TEST(CommandQueue, HandsOnInOrder) {
  CommandQueue queue;
  EXPECT_EQ(queue.take(), std::nullopt);
  for (std::int64_t round = 0; round < 1000; ++round) {
    EXPECT_TRUE(queue.push(numbered(2 * round)));
    EXPECT_TRUE(queue.push(numbered(2 * round + 1)));
    EXPECT_EQ(queue.take(), numbered(2 * round));
    EXPECT_EQ(queue.take(), numbered(2 * round + 1));
    EXPECT_EQ(queue.take(), std::nullopt);
  }
}

TEST(CommandQueue, TakesNoMoreThanItHolds) {
  CommandQueue queue;
  for (std::size_t i = 0; i < CommandQueue::kSlots; ++i) EXPECT_TRUE(queue.push(numbered(1)));
  EXPECT_FALSE(queue.push(numbered(2)));
  EXPECT_TRUE(queue.take());
  EXPECT_TRUE(queue.push(numbered(3)));
  EXPECT_FALSE(queue.push(numbered(4)));
}

TEST(CommandQueue, LosesNothingBetweenThreads) {
  constexpr std::size_t kThreads = 4;
  constexpr std::int64_t kEach = 20'000;
  CommandQueue queue;
  std::vector<std::thread> pushers;
  for (std::size_t from = 0; from < kThreads; ++from) {
    pushers.emplace_back([&queue, from] {
      for (std::int64_t i = 0; i < kEach; ++i) {
        while (!queue.push(numbered(i, from))) std::this_thread::yield();
      }
    });
  }
  std::array<std::int64_t, kThreads> next{};
  for (std::int64_t taken = 0; taken < kEach * static_cast<std::int64_t>(kThreads);) {
    const std::optional<PlayerCommand> command = queue.take();
    if (!command) {
      std::this_thread::yield();
      continue;
    }
    EXPECT_EQ(*command, numbered(next[command->cue]++, command->cue));
    ++taken;
  }
  for (std::thread& pusher : pushers) pusher.join();
  EXPECT_EQ(queue.take(), std::nullopt);
}

}  // namespace
}  // namespace cupola
