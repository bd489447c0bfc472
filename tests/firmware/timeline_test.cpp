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

TEST(Timeline, HoldsTheLastFrameOfACueThatWaitsUntilGo) {
  Timeline timeline(Cues{{.frames = 3, .then = 1, .wait = true}, {.frames = 2}});
  for (std::int64_t i = 0; i < 3; ++i) {
    ASSERT_EQ(timeline.at(flip(i)), (Moment{0, i}));
    ASSERT_FALSE(timeline.waiting()) << i;
  }
  for (std::int64_t i = 3; i < 1000; ++i) {
    ASSERT_EQ(timeline.at(flip(i)), (Moment{0, 2}));
    ASSERT_TRUE(timeline.waiting()) << i;
  }
  EXPECT_EQ(timeline.position(flip(1000)), timeline.cue_length());
  timeline.go(flip(1000));
  EXPECT_EQ(timeline.at(flip(1000)), (Moment{1, 0}));
  EXPECT_EQ(timeline.at(flip(1001)), (Moment{1, 1}));
  EXPECT_EQ(timeline.at(flip(1002)), std::nullopt);
}

TEST(Timeline, GoesOnlyWhereACueWaits) {
  Timeline timeline(Cues{{.frames = 3, .then = 1, .wait = true}, {.frames = 2}});
  EXPECT_EQ(timeline.at(flip(0)), (Moment{0, 0}));
  timeline.go(flip(1));
  EXPECT_EQ(timeline.at(flip(1)), (Moment{0, 1})) << "it does not wait yet";
  timeline.next_cue(flip(2));
  EXPECT_EQ(timeline.at(flip(2)), (Moment{1, 0})) << "next does not ask";
}

TEST(Timeline, LeavesALoopThatWaitsWhenItIsToldToGo) {
  Timeline timeline(Cues{{.frames = 3, .loop = true, .then = 1, .wait = true}, {.frames = 2}});
  for (std::int64_t i = 0; i < 100; ++i) ASSERT_EQ(timeline.at(flip(i)), (Moment{0, i % 3}));
  timeline.go(flip(100));
  EXPECT_EQ(timeline.at(flip(100)), (Moment{1, 0}));
}

TEST(Timeline, WaitsForEverAtTheEndOfTheLastCueIfThatWaits) {
  Timeline timeline(Cues{{.frames = 3, .wait = true}});
  EXPECT_EQ(timeline.at(flip(5)), (Moment{0, 2}));
  timeline.go(flip(6));
  timeline.next_cue(flip(6));
  EXPECT_EQ(timeline.at(flip(6)), (Moment{0, 2})) << "nothing follows it";
  EXPECT_TRUE(timeline.waiting());
  timeline.jump(0, flip(7));
  EXPECT_EQ(timeline.at(flip(7)), (Moment{0, 0}));
  EXPECT_FALSE(timeline.waiting());
}

TEST(Timeline, GoesBackToTheCueBeforeAndFromTheFirstToItsStart) {
  Timeline timeline(Cues{{.frames = 60, .then = 2}, {.first = 5, .frames = 60}, {.frames = 60}});
  EXPECT_EQ(timeline.at(flip(70)), (Moment{2, 10}));
  timeline.previous_cue(flip(71));
  EXPECT_EQ(timeline.at(flip(71)), (Moment{1, 5})) << "the one before in the list, not the one played before";
  timeline.previous_cue(flip(80));
  EXPECT_EQ(timeline.at(flip(80)), (Moment{0, 0}));
  EXPECT_EQ(timeline.at(flip(90)), (Moment{0, 10}));
  timeline.previous_cue(flip(91));
  EXPECT_EQ(timeline.at(flip(91)), (Moment{0, 0}));
}

TEST(Timeline, JumpsToAnyCueAndGoesOnFromThere) {
  Timeline timeline(Cues{{.frames = 60, .then = 1}, {.frames = 4, .then = 2}, {.frames = 60}});
  EXPECT_EQ(timeline.at(flip(0)), (Moment{0, 0}));
  timeline.jump(1, flip(10));
  for (std::int64_t i = 0; i < 4; ++i) ASSERT_EQ(timeline.at(flip(10 + i)), (Moment{1, i}));
  EXPECT_EQ(timeline.at(flip(14)), (Moment{2, 0}));
}

TEST(Timeline, SeeksForwardsAndBackwardsWithinACue) {
  Timeline timeline(Cues{{.first = 100, .frames = 600, .then = 1}, {.frames = 60}});
  EXPECT_EQ(timeline.at(flip(30)), (Moment{0, 130}));
  timeline.seek(9s, flip(31));
  EXPECT_EQ(timeline.at(flip(31)), (Moment{0, 640}));
  EXPECT_EQ(timeline.position(flip(31)), nanoseconds(9s));
  EXPECT_EQ(timeline.at(flip(32)), (Moment{0, 641}));
  timeline.seek(500ms, flip(33));
  EXPECT_EQ(timeline.at(flip(33)), (Moment{0, 130}));
  timeline.seek(-1s, flip(34));
  EXPECT_EQ(timeline.at(flip(34)), (Moment{0, 100}));
  timeline.seek(1h, flip(35));
  EXPECT_EQ(timeline.at(flip(35)), (Moment{1, 0})) << "past its end, what follows begins";
}

TEST(Timeline, SeeksOutOfAWaitAndIntoIt) {
  Timeline timeline(Cues{{.frames = 60, .then = 1, .wait = true}, {.frames = 60}});
  EXPECT_EQ(timeline.at(flip(90)), (Moment{0, 59}));
  timeline.seek(500ms, flip(91));
  EXPECT_EQ(timeline.at(flip(91)), (Moment{0, 30}));
  EXPECT_FALSE(timeline.waiting());
  timeline.seek(1h, flip(92));
  EXPECT_EQ(timeline.at(flip(92)), (Moment{0, 59}));
  EXPECT_TRUE(timeline.waiting());
}

TEST(Timeline, TakesNoOrdersWhenItIsOver) {
  Timeline timeline(Cues{{.frames = 2}});
  EXPECT_EQ(timeline.at(flip(2)), std::nullopt);
  timeline.jump(0, flip(3));
  timeline.seek(0s, flip(3));
  timeline.previous_cue(flip(3));
  EXPECT_EQ(timeline.at(flip(3)), std::nullopt);
}

TEST(Timeline, KnowsHowLongTheShowIs) {
  EXPECT_EQ(Timeline(Cues{{.frames = 30, .then = 1}, {.rate = 10.0, .frames = 30}}).length(),
            nanoseconds(3500ms));
  EXPECT_EQ(Timeline(Cues{{.duration = 2s}}).length(), nanoseconds(2s));
  EXPECT_EQ(Timeline(Cues{{.frames = 30, .loop = true}}).length(), std::nullopt);
  EXPECT_EQ(Timeline(Cues(1)).length(), std::nullopt);
  EXPECT_EQ(Timeline(Cues{{.frames = 30, .then = 1, .wait = true}, {.frames = 30}}).length(), std::nullopt);
}

TEST(Timeline, SlowCuesLastTheirWholeTime) {
  // Three stills of two seconds each: 360 flips at 60 Hz, 120 of each.
  Timeline timeline(Cues{{.rate = 0.5, .frames = 3}});
  for (std::int64_t i = 0; i < 360; ++i) ASSERT_EQ(timeline.at(flip(i)), (Moment{0, i / 120})) << i;
  EXPECT_EQ(timeline.at(flip(360)), std::nullopt);
}

TEST(Timeline, SaysWhereTheShowWillBe) {
  CueTiming first;
  first.duration = 2s;
  first.then = 1;
  CueTiming second;
  second.duration = 3s;
  second.then = 0;
  CueTiming third;
  third.duration = 1s;
  third.then = 0;
  third.wait = true;
  const Timeline timeline({first, second, third});
  EXPECT_EQ(timeline.ahead({0, 1s}, 500ms)->position, 1500ms);
  EXPECT_EQ(timeline.ahead({0, 1s}, 1500ms)->cue, 1U);
  EXPECT_EQ(timeline.ahead({0, 1s}, 1500ms)->position, 500ms);
  EXPECT_EQ(timeline.ahead({0, 1s}, 4200ms)->cue, 0U) << "around";
  EXPECT_EQ(timeline.ahead({0, 1s}, -2s)->position, 0s);
  EXPECT_FALSE(timeline.ahead({2, 500ms}, 600ms)) << "it waits there";
}

}  // namespace
}  // namespace cupola
