// Buffers' turns: two while all goes well, never one that is seen, ages that hold.
// SPDX-License-Identifier: MIT
#include "hal/display/scanout_turns.h"

#include <array>
#include <cstdint>
#include <random>
#include <set>

#include <gtest/gtest.h>

namespace cupola {
namespace {

void show(ScanoutTurns& turns) {
  turns.presented();
  turns.committed();
  turns.flipped();
}

TEST(ScanoutTurns, TakesTwoInTurnsWhileEveryFlipComes) {
  ScanoutTurns turns;
  EXPECT_EQ(turns.age(), 0);
  show(turns);
  EXPECT_EQ(turns.age(), 0);
  show(turns);
  std::set<int> used;
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(turns.age(), 2);
    used.insert(turns.back());
    show(turns);
  }
  EXPECT_EQ(used.size(), 2U);
}

TEST(ScanoutTurns, RepeatsWithoutAgeing) {
  ScanoutTurns turns;
  show(turns);
  show(turns);
  for (int i = 0; i < 3; ++i) {
    turns.committed();
    turns.flipped();
    EXPECT_EQ(turns.age(), 2);
  }
}

TEST(ScanoutTurns, GoesOnWithTheThirdWhileAFlipIsStuck) {
  ScanoutTurns turns;
  show(turns);
  const int seen = turns.last();
  turns.presented();
  turns.committed();
  const int stuck = turns.last();
  EXPECT_TRUE(turns.in_flight());
  for (int i = 0; i < 4; ++i) {
    EXPECT_NE(turns.back(), seen);
    EXPECT_NE(turns.back(), stuck);
    EXPECT_EQ(turns.age(), i == 0 ? 0 : 1);
    turns.presented();
  }
  turns.flipped();
  EXPECT_FALSE(turns.in_flight());
  EXPECT_EQ(turns.back(), seen) << "free now, and not the frame that is to be shown next";
  EXPECT_EQ(turns.age(), 6);
}

TEST(ScanoutTurns, StartsAnewWhenToldToForget) {
  ScanoutTurns turns;
  show(turns);
  turns.forget();
  EXPECT_EQ(turns.last(), -1);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(turns.age(), 0);
    show(turns);
  }
  EXPECT_EQ(turns.age(), 2);
}

TEST(ScanoutTurns, KeepsOnlyTheLastFrameInNewBuffers) {
  ScanoutTurns turns;
  for (int i = 0; i < 5; ++i) show(turns);
  turns.presented();
  turns.replaced();
  EXPECT_EQ(turns.last(), 0);
  EXPECT_NE(turns.back(), 0);
  EXPECT_EQ(turns.age(), 0);
  turns.committed();
  turns.flipped();
  show(turns);
  EXPECT_EQ(turns.back(), 0);
  EXPECT_EQ(turns.age(), 2);
}

// Against buffers that really hold numbers, whatever happens in whatever order.
TEST(ScanoutTurns, TellsTheAgeOfWhatIsInTheBuffer) {
  std::mt19937 random(1);
  for (int run = 0; run < 200; ++run) {
    ScanoutTurns turns;
    std::array<std::int64_t, ScanoutTurns::kBuffers> held{};
    std::int64_t presents = 0;
    int screen = -1;
    int in_flight = -1;
    for (int step = 0; step < 200; ++step) {
      const auto what = random() % 8;
      if (what < 4) {
        const auto back = static_cast<std::size_t>(turns.back());
        ASSERT_NE(turns.back(), screen);
        ASSERT_NE(turns.back(), in_flight);
        if (turns.age() > 0) {
          ASSERT_EQ(held[back], presents + 1 - turns.age());
        }
        held[back] = ++presents;
        turns.presented();
        ASSERT_EQ(turns.last(), static_cast<int>(back));
      }
      if (what < 6 && in_flight < 0 && turns.last() >= 0) {
        turns.committed();
        in_flight = turns.last();
      }
      if (what < 7 && in_flight >= 0 && random() % 4 != 0) {
        turns.flipped();
        screen = in_flight;
        in_flight = -1;
      }
      if (what == 7) {
        turns.switched_off();
        screen = in_flight = -1;
      }
      ASSERT_EQ(turns.in_flight(), in_flight >= 0);
    }
  }
}

}  // namespace
}  // namespace cupola
