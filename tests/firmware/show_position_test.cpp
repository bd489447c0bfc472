// The position file: written, read back, and asked where the show would be.
// SPDX-License-Identifier: MIT
#include "firmware/show_position.h"

#include <gtest/gtest.h>

#include "firmware/timeline.h"
#include "pipeline/frame/error.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;

ShowPosition some_position() {
  ShowPosition position;
  position.show = "night \"1\"\n";
  position.cue = 1;
  position.cue_name = "dome";
  position.position = 12'345'678'901ns;
  position.at = {"boot-a", 100s, 1'700'000'000s};
  position.dark = true;
  position.volume = 35;
  return position;
}
const std::vector<std::string> kCues = {"opening", "dome", "end"};

TEST(ShowPosition, IsReadAsItWasWritten) {
  const ShowPosition is = parse_position(position_text(some_position()));
  EXPECT_EQ(is.show, some_position().show);
  EXPECT_EQ(is.cue, 1U);
  EXPECT_EQ(is.cue_name, "dome");
  EXPECT_EQ(is.position, 12'345'678'901ns);
  EXPECT_EQ(is.at.boot, "boot-a");
  EXPECT_EQ(is.at.booted, 100s);
  EXPECT_EQ(is.at.wall, 1'700'000'000s);
  EXPECT_TRUE(is.dark);
  EXPECT_FALSE(is.held);
  EXPECT_EQ(is.volume, 35);
}

TEST(ShowPosition, OfAPlayerWithoutSoundHasNoVolume) {
  ShowPosition position = some_position();
  position.volume.reset();
  EXPECT_FALSE(parse_position(position_text(position)).volume);
}

TEST(ShowPosition, CutAnywhereIsRefused) {
  const std::string whole = position_text(some_position());
  for (std::size_t length = 0; length + 2 < whole.size(); ++length) {
    EXPECT_THROW(parse_position(std::string_view(whole).substr(0, length)), InputError) << length;
  }
}

TEST(ShowPosition, WithValuesThatNobodyWritesIsRefused) {
  const std::pair<const char*, const char*> wrong[] = {{"\"cue\": 2", "\"cue\": 0"},
                                                       {"\"cue\": 2", "\"cue\": -1"},
                                                       {"\"cue\": 2", "\"cue\": 2.5"},
                                                       {"\"cue\": 2", "\"cue\": [2]"},
                                                       {"\"cue\": 2", "\"cue\": 18446744073709551615"},
                                                       {"12345678901", "9223372036854775807"},
                                                       {"12345678901", "1e300"},
                                                       {"\"dark\": true", "\"dark\": 1"},
                                                       {"\"volume\": 35", "\"volume\": 135"},
                                                       {"_position\": 1", "_position\": 2"}};
  for (const auto& [from, to] : wrong) {
    std::string text = position_text(some_position());
    text.replace(text.find(from), std::string(from).size(), to);
    EXPECT_THROW(parse_position(text), InputError) << text;
  }
}

TEST(ShowPosition, GoesOnByTheBootsClockWhereTheMachineStayedUp) {
  const auto place = resume_at(some_position(), kCues, {"boot-a", 103s, 5s});
  ASSERT_TRUE(place);
  EXPECT_EQ(place->cue, 1U);
  EXPECT_EQ(place->played, 12'345'678'901ns + 3s) << "the wall's clock was set";
}

TEST(ShowPosition, GoesOnByTheWallsClockWhereTheMachineBeganAnew) {
  EXPECT_EQ(resume_at(some_position(), kCues, {"boot-b", 20s, 1'700'000'060s})->played,
            12'345'678'901ns + 60s);
  EXPECT_EQ(resume_at(some_position(), kCues, {"boot-b", 20s, 1'600'000'000s})->played, 12'345'678'901ns)
      << "a clock that lost its battery";
}

TEST(ShowPosition, StandsWhereTheShowWasHeld) {
  ShowPosition held = some_position();
  held.held = true;
  EXPECT_EQ(resume_at(held, kCues, {"boot-a", 9000s, 0s})->played, 12'345'678'901ns);
}

TEST(ShowPosition, FindsItsCueWhereTheShowWasChanged) {
  const std::vector<std::string> moved = {"dome", "end"};
  EXPECT_EQ(resume_at(some_position(), moved, {})->cue, 0U);
  const std::vector<std::string> gone = {"opening", "end"};
  EXPECT_FALSE(resume_at(some_position(), gone, {}));
  const std::vector<std::string> twice = {"dome", "dome"};
  EXPECT_EQ(resume_at(some_position(), twice, {})->cue, 1U);
}

TEST(ShowPosition, IsWhereAShowThatWentOnWouldBe) {
  const std::vector<CueTiming> cues = {{.rate = 10.0, .frames = 100, .then = 1},
                                       {.rate = 10.0, .frames = 50, .then = 0, .fade_frames = 5}};
  for (const auto away : {0ms, 700ms, 4'900ms, 61'300ms}) {
    Timeline went_on(cues);
    went_on.at(12s);  // 2 s into the second cue
    Timeline again(cues);
    again.begin_in(1, 2s + away);
    for (int step = 0; step < 40; ++step) {
      EXPECT_EQ(again.at(step * 100ms), went_on.at(12s + away + step * 100ms)) << away.count();
    }
  }
}

}  // namespace
}  // namespace cupola
