// What is said of a cue's cost.
// SPDX-License-Identifier: MIT
#include "firmware/cue_trial.h"

#include <gtest/gtest.h>

namespace cupola {
namespace {

TEST(FrameCost, OfTheLoopIsItsOwnWorkAndItsShareOfTheDecoder) {
  const FrameCost cost{.rate = 50, .threads = 4, .decode_ms = 4.0, .faces_ms = 0, .warp_ms = 3.0};
  EXPECT_DOUBLE_EQ(share_of_frame(cost), 0.2);  // 3 ms + 4 ms / 4 of 20 ms
  EXPECT_EQ(prediction(cost),
            "50 a second; decode 4.0 ms on one core ahead, warp 3.0 ms; holds (20 % of a frame's time)");
}

TEST(FrameCost, OfADecoderThatIsSlowerThanTheLoopCounts) {
  const FrameCost cost{.rate = 50, .threads = 16, .decode_ms = 25.0, .faces_ms = 0, .warp_ms = 3.0};
  EXPECT_FALSE(holds(cost));
  EXPECT_EQ(prediction(cost),
            "50 a second; decode 25.0 ms on one core ahead, warp 3.0 ms; does not hold: at most 40 a second");
}

TEST(FrameCost, OfAFadeIsTwoWarps) {
  const FrameCost cost{
      .rate = 100, .threads = 2, .decode_ms = {}, .faces_ms = 1.0, .warp_ms = 2.0, .fades = true};
  EXPECT_DOUBLE_EQ(share_of_frame(cost), 0.5);
  EXPECT_EQ(prediction(cost),
            "100 a second; faces 1.0 ms, warp 2.0 ms, twice in its fade; holds (50 % of a frame's time)");
}

}  // namespace
}  // namespace cupola
