// Which flip a frame is for.
// SPDX-License-Identifier: MIT
#include "hal/display/flip_time.h"

#include <gtest/gtest.h>

namespace cupola {
namespace {

using namespace std::chrono_literals;

TEST(FlipTime, IsTheFirstAtOrAfterTheFramesTime) {
  EXPECT_EQ(next_flip(100ms, 16ms, 116ms, 101ms), 116ms);
  EXPECT_EQ(next_flip(100ms, 16ms, 118ms, 101ms), 132ms);
  EXPECT_EQ(next_flip(100ms, 16ms, 1s, 101ms), 1012ms);
}

TEST(FlipTime, IsTheFirstToComeForLateFrames) {
  EXPECT_EQ(next_flip(100ms, 16ms, 0ms, 101ms), 116ms);
  EXPECT_EQ(next_flip(100ms, 16ms, 110ms, 140ms), 148ms);
}

TEST(FlipTime, ForgivesTheRasterASixteenthOfAPeriod) {
  EXPECT_EQ(next_flip(100ms, 16ms, 117ms, 101ms), 116ms);
  EXPECT_EQ(next_flip(100ms, 16ms, 117ms + 1ns, 101ms), 132ms);
}

TEST(FlipTime, IsNeverTheOneThatHasBeen) {
  EXPECT_EQ(next_flip(100ms, 16ms, 100ms, 100ms), 116ms);
  EXPECT_EQ(next_flip(100ms, 16ms, 0ms, 20ms), 116ms) << "the last flip is still to come";
}

}  // namespace
}  // namespace cupola
