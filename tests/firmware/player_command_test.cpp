// The words for commands, right and wrong.
// SPDX-License-Identifier: MIT
#include "firmware/player_command.h"

#include <gmock/gmock.h>

#include <vector>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

const std::vector<std::string> kCues = {"opening", "dome", "2", "end"};

std::string refusal(std::string_view word, std::string_view argument,
                    std::span<const std::string> cues = kCues) {
  try {
    parse_command(word, argument, cues);
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

TEST(PlayerCommand, IsOneOfTheSetByItsName) {
  EXPECT_EQ(parse_command("play", "", kCues), (PlayerCommand{PlayerAction::kPlay}));
  EXPECT_EQ(parse_command("pause", "", kCues), (PlayerCommand{PlayerAction::kPause}));
  EXPECT_EQ(parse_command("play-pause", "", kCues), (PlayerCommand{PlayerAction::kPlayPause}));
  EXPECT_EQ(parse_command("go", "", kCues), (PlayerCommand{PlayerAction::kGo}));
  EXPECT_EQ(parse_command("next", "", kCues), (PlayerCommand{PlayerAction::kNext}));
  EXPECT_EQ(parse_command("previous", "", kCues), (PlayerCommand{PlayerAction::kPrevious}));
  EXPECT_EQ(parse_command("blackout", "", kCues), (PlayerCommand{PlayerAction::kBlackoutToggle}));
  EXPECT_EQ(parse_command("blackout", "toggle", kCues), (PlayerCommand{PlayerAction::kBlackoutToggle}));
  EXPECT_EQ(parse_command("blackout", "on", kCues), (PlayerCommand{PlayerAction::kBlackout}));
  EXPECT_EQ(parse_command("blackout", "off", kCues), (PlayerCommand{PlayerAction::kBlackoutOff}));
  EXPECT_EQ(parse_command("fade", "", kCues), (PlayerCommand{PlayerAction::kFade, 2s}));
  EXPECT_EQ(parse_command("fade", "0.5", kCues), (PlayerCommand{PlayerAction::kFade, 500ms}));
  EXPECT_EQ(parse_command("fade", "out 3", kCues), (PlayerCommand{PlayerAction::kFadeOut, 3s}));
  EXPECT_EQ(parse_command("fade", "in", kCues), (PlayerCommand{PlayerAction::kFadeIn, 2s}));
  EXPECT_EQ(parse_command("seek", "12.5", kCues), (PlayerCommand{PlayerAction::kSeek, 12500ms}));
  EXPECT_EQ(parse_command("screenshot", "", kCues), (PlayerCommand{PlayerAction::kScreenshot}));
  EXPECT_EQ(parse_command("reload", "", kCues), (PlayerCommand{PlayerAction::kReload}));
  EXPECT_EQ(parse_command("test-pattern", "", kCues), (PlayerCommand{PlayerAction::kTestPatternNext}));
  EXPECT_EQ(parse_command("test-pattern", "off", kCues), (PlayerCommand{PlayerAction::kTestPattern}));
  EXPECT_EQ(parse_command("test-pattern", "focus", kCues),
            (PlayerCommand{PlayerAction::kTestPattern, {}, 3}));
  EXPECT_THAT(refusal("test-pattern", "gird"), HasSubstr("did you mean grid?"));
  EXPECT_THAT(refusal("screenshot", "/etc/passwd"), HasSubstr("expected nothing after it"));
  EXPECT_EQ(parse_command("seek", "0", kCues), (PlayerCommand{PlayerAction::kSeek}));
  EXPECT_EQ(parse_command("volume", "80", kCues),
            (PlayerCommand{.action = PlayerAction::kVolume, .volume = 80}));
  EXPECT_EQ(parse_command("volume", "+5", kCues),
            (PlayerCommand{.action = PlayerAction::kVolumeBy, .volume = 5}));
  EXPECT_EQ(parse_command("volume", "-5", kCues),
            (PlayerCommand{.action = PlayerAction::kVolumeBy, .volume = -5}));
  EXPECT_EQ(describe(parse_command("volume", "-5", kCues), kCues), "volume -5");
  EXPECT_EQ(describe(parse_command("volume", "7", kCues), kCues), "volume 7");
  EXPECT_EQ(command_of_key('+')->volume, 5);
  EXPECT_EQ(command_of_key('-')->volume, -5);
}

TEST(PlayerCommand, FindsACueByItsNameFirstAndThenByItsNumber) {
  EXPECT_EQ(parse_command("cue", "dome", kCues).cue, 1U);
  EXPECT_EQ(parse_command("cue", "1", kCues).cue, 0U);
  EXPECT_EQ(parse_command("cue", "2", kCues).cue, 2U) << "a cue has that name";
  EXPECT_EQ(parse_command("cue", "4", kCues).cue, 3U);
}

TEST(PlayerCommand, RefusesWhatIsNoCommandAndSaysWhatIs) {
  EXPECT_THAT(refusal("nxt", ""), HasSubstr("no such command; expected one of play, pause"));
  EXPECT_THAT(refusal("nxt", ""), HasSubstr("did you mean next?"));
  EXPECT_THAT(refusal("", ""), HasSubstr("no such command"));
  for (const char* volume : {"", "loud", "101", "-101", "+101", "1e1", "+-5", "++5", "5 "})
    EXPECT_THAT(refusal("volume", volume), HasSubstr("volume: expected percent from 0 to 100"));
  for (const char* fade : {"up 2", "out -1", "3601", "out2", "out  2", "in nan", "2 out"}) {
    EXPECT_THAT(refusal("fade", fade), HasSubstr("fade: expected seconds from 0 to 3600")) << fade;
  }
  EXPECT_EQ(refusal("play", "2"), "play: expected nothing after it, not \"2\"");
  EXPECT_EQ(refusal("blackout", "maybe"), "blackout: expected on, off or toggle, not \"maybe\"");
}

TEST(PlayerCommand, RefusesPlacesThatAreNone) {
  for (const char* seconds : {"", "-1", "1e8", "nan", "inf", "12x", "0x10", " 1"}) {
    EXPECT_THAT(refusal("seek", seconds), HasSubstr("seek: expected seconds from 0 to 10000000")) << seconds;
  }
  for (const char* cue : {"", "0", "5", "-1", "99999999999999999999", "../show.toml"}) {
    EXPECT_THAT(refusal("cue", cue), HasSubstr("cue: expected a cue's name or a number from 1 to 4")) << cue;
  }
  EXPECT_THAT(refusal("cue", "dom"), HasSubstr("did you mean dome?"));
}

TEST(PlayerCommand, IsDescribedAsItIsParsed) {
  const std::pair<const char*, const char*> all[] = {
      {"play", ""},     {"pause", ""},   {"play-pause", ""}, {"go", ""},          {"next", ""},
      {"previous", ""}, {"seek", "2.5"}, {"cue", "end"},     {"blackout", "off"}, {"blackout", "on"},
      {"blackout", ""}, {"fade", "2.5"}, {"fade", "out 1"},  {"fade", "in 0"}};
  for (const auto& [word, argument] : all) {
    const std::string expected = *argument ? std::string(word) + " " + argument : word;
    EXPECT_EQ(describe(parse_command(word, argument, kCues), kCues), expected);
  }
}

TEST(PlayerCommand, HasKeys) {
  EXPECT_EQ(command_of_key(' '), PlayerCommand{PlayerAction::kPlayPause});
  EXPECT_EQ(command_of_key('g'), PlayerCommand{PlayerAction::kGo});
  EXPECT_EQ(command_of_key('n'), PlayerCommand{PlayerAction::kNext});
  EXPECT_EQ(command_of_key('>'), PlayerCommand{PlayerAction::kNext});
  EXPECT_EQ(command_of_key('p'), PlayerCommand{PlayerAction::kPrevious});
  EXPECT_EQ(command_of_key('<'), PlayerCommand{PlayerAction::kPrevious});
  EXPECT_EQ(command_of_key('b'), PlayerCommand{PlayerAction::kBlackoutToggle});
  EXPECT_EQ(command_of_key('f'), (PlayerCommand{PlayerAction::kFade, 2s}));
  EXPECT_EQ(command_of_key('x'), std::nullopt);
}

}  // namespace
}  // namespace cupola
