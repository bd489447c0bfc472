// Numbers keep their order between threads, and the descriptor tells the truth.
// SPDX-License-Identifier: MIT
#include "hal/camera/hand_over.h"

#include <gmock/gmock.h>
#include <poll.h>

#include <thread>

namespace cupola {
namespace {

bool readable(const HandOver& hand_over) {
  pollfd polled{hand_over.descriptor(), POLLIN, 0};
  return poll(&polled, 1, 0) == 1;
}

TEST(HandOver, GivesTheOldestFirstAndIsReadableWhileItHasSome) {
  HandOver hand_over;
  ASSERT_GE(hand_over.descriptor(), 0);
  EXPECT_FALSE(readable(hand_over));
  EXPECT_EQ(hand_over.pop(), std::nullopt);
  EXPECT_TRUE(hand_over.push(7));
  EXPECT_TRUE(hand_over.push(-1));
  EXPECT_TRUE(readable(hand_over));
  EXPECT_EQ(hand_over.pop(), 7);
  EXPECT_TRUE(readable(hand_over));
  EXPECT_EQ(hand_over.pop(), -1);
  EXPECT_FALSE(readable(hand_over));
  EXPECT_EQ(hand_over.pop(), std::nullopt);
}

TEST(HandOver, RefusesWhatDoesNotFitAndGoesOnAfterwards) {
  HandOver hand_over;
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < HandOver::kCapacity; ++i) ASSERT_TRUE(hand_over.push(static_cast<int>(i)));
    EXPECT_FALSE(hand_over.push(1000));
    for (std::size_t i = 0; i < HandOver::kCapacity; ++i) ASSERT_EQ(hand_over.pop(), static_cast<int>(i));
    EXPECT_EQ(hand_over.pop(), std::nullopt);
  }
}

TEST(HandOver, WakesWithoutAValue) {
  HandOver hand_over;
  hand_over.wake();
  EXPECT_TRUE(readable(hand_over));
  EXPECT_EQ(hand_over.pop(), std::nullopt);
  EXPECT_FALSE(readable(hand_over));
  hand_over.wake();
  hand_over.push(3);
  EXPECT_EQ(hand_over.pop(), 3);
  EXPECT_EQ(hand_over.pop(), std::nullopt);
}

TEST(HandOver, LosesNothingBetweenThreads) {
  constexpr int kNumbers = 100'000;
  HandOver hand_over;
  std::thread sender([&] {
    for (int i = 0; i < kNumbers;) {
      if (hand_over.push(i)) {
        ++i;
      } else {
        std::this_thread::yield();
      }
      if (i % 1000 == 0) hand_over.wake();
    }
  });
  int wrong = 0;
  for (int i = 0; i < kNumbers; ++i) wrong += hand_over.wait() != i;
  sender.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace cupola
