// Which frame is due when.
// SPDX-License-Identifier: MIT
#include "firmware/timeline.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

using Cues = std::vector<CueTiming>;

nanoseconds flip(std::int64_t number) {
  return number * nanoseconds(1s) / 60;
}

TEST(Timeline, ShowsEachFrameOfACueOnceAtItsOwnRate) {
  Timeline timeline(Cues{{.rate = 60.0, .frames = 100}});
  for (std::int64_t i = 0; i < 100; ++i) ASSERT_EQ(timeline.at(flip(i)), (Moment{0, i}));
  EXPECT_EQ(timeline.at(flip(100)), std::nullopt);
  EXPECT_EQ(timeline.at(flip(101)), std::nullopt);
}

TEST(Timeline, HoldsFramesOfASlowerCue) {
  Timeline timeline(Cues{{.rate = 30.0, .frames = 10}});
  for (std::int64_t i = 0; i < 20; ++i) ASSERT_EQ(timeline.at(flip(i)), (Moment{0, i / 2}));
  EXPECT_EQ(timeline.at(flip(20)), std::nullopt);
}

TEST(Timeline, BearsFlipsThatJitter) {
  Timeline timeline(Cues{{.rate = 60.0}});
  for (std::int64_t i = 0; i < 1000; ++i) {
    const nanoseconds jitter = (i % 2 == 0 ? 3ms : -3ms);
    ASSERT_EQ(timeline.at(flip(i) + jitter), (Moment{0, i}));
  }
}

TEST(Timeline, StaysOnTheFrameForAnHour) {
  Timeline timeline(Cues{{.rate = 60.0}});
  for (std::int64_t i = 0; i < 60 * 3600; ++i) ASSERT_EQ(timeline.at(flip(i)), (Moment{0, i}));
}

TEST(Timeline, BeginsAndLoopsWhereItIsTold) {
  Timeline timeline(Cues{{.rate = 60.0, .first = 7, .frames = 3, .loop = true, .duration = 1s}});
  EXPECT_EQ(timeline.at(flip(0)), (Moment{0, 7}));
  EXPECT_EQ(timeline.at(flip(2)), (Moment{0, 9}));
  EXPECT_EQ(timeline.at(flip(3)), (Moment{0, 7}));
  EXPECT_EQ(timeline.at(flip(59)), (Moment{0, 9}));
  EXPECT_EQ(timeline.at(flip(60)), std::nullopt);
}

TEST(Timeline, HoldsTheLastFrameOfACueThatLastsLonger) {
  Timeline timeline(Cues{{.rate = 60.0, .frames = 3, .duration = 1s}});
  EXPECT_EQ(timeline.at(flip(30)), (Moment{0, 2}));
}

TEST(Timeline, GoesFromCueToCueAndBack) {
  Timeline timeline(Cues{{.frames = 2, .then = 1}, {.frames = 3, .then = 0}});
  const Moment expected[] = {{0, 0}, {0, 1}, {1, 0}, {1, 1}, {1, 2}, {0, 0}, {0, 1}, {1, 0}};
  for (std::int64_t i = 0; i < 8; ++i) ASSERT_EQ(timeline.at(flip(i)), expected[i]) << i;
  EXPECT_EQ(timeline.length(), std::nullopt);
}

TEST(Timeline, SkipsCuesWhoseTimeHasPassed) {
  Timeline timeline(Cues{{.frames = 60, .then = 1}, {.frames = 60, .then = 2}, {.frames = 60}});
  EXPECT_EQ(timeline.at(flip(0)), (Moment{0, 0}));
  EXPECT_EQ(timeline.at(flip(150)), (Moment{2, 30}));
}

TEST(Timeline, GoesToTheNextCueWhenItIsTold) {
  Timeline timeline(Cues{{.frames = 60, .then = 2}, {.frames = 60}, {.first = 5}});
  EXPECT_EQ(timeline.at(flip(7)), (Moment{0, 7}));
  timeline.next_cue(flip(8));
  for (std::int64_t i = 0; i < 100; ++i) ASSERT_EQ(timeline.at(flip(8 + i)), (Moment{2, 5 + i}));
  timeline.next_cue(flip(108));
  EXPECT_EQ(timeline.at(flip(108)), (Moment{2, 105})) << "nothing follows the last cue";
}

TEST(Timeline, StaysOverWhenItIsOver) {
  Timeline timeline(Cues{{.frames = 2, .then = 1}, {.frames = 2}});
  EXPECT_EQ(timeline.at(flip(4)), std::nullopt);
  timeline.next_cue(flip(5));
  EXPECT_EQ(timeline.at(flip(5)), std::nullopt);
}

TEST(Timeline, KnowsHowLongTheShowIs) {
  EXPECT_EQ(Timeline(Cues{{.frames = 30, .then = 1}, {.rate = 10.0, .frames = 30}}).length(),
            nanoseconds(3500ms));
  EXPECT_EQ(Timeline(Cues{{.duration = 2s}}).length(), nanoseconds(2s));
  EXPECT_EQ(Timeline(Cues{{.frames = 30, .loop = true}}).length(), std::nullopt);
  EXPECT_EQ(Timeline(Cues(1)).length(), std::nullopt);
}

TEST(Timeline, SlowCuesLastTheirWholeTime) {
  // Three stills of two seconds each: 360 flips at 60 Hz, 120 of each.
  Timeline timeline(Cues{{.rate = 0.5, .frames = 3}});
  for (std::int64_t i = 0; i < 360; ++i) ASSERT_EQ(timeline.at(flip(i)), (Moment{0, i / 120})) << i;
  EXPECT_EQ(timeline.at(flip(360)), std::nullopt);
}

}  // namespace
}  // namespace cupola
