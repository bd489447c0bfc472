// Cameras from the command line: what is there, whether the rig's work, and a live show of fake ones.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/firmware/program.h"

namespace cupola {
namespace {

using testing::HasSubstr;

class Live : public ProgramTest {};

TEST_F(Live, ARigsCamerasAreTried) {
  const Outcome good = call({"check", "--rig", "four-fake-cameras"});
  EXPECT_EQ(good.code, 0) << good.err;
  for (const char* view : {"front", "left", "right", "top"}) {
    EXPECT_THAT(good.out, HasSubstr(std::string("camera ") + view));
  }
  EXPECT_THAT(good.out, HasSubstr("60.00 a second"));
  const Outcome wrong = call({"check", "--rig", "four-fake-cameras", "--set", "camera.1.view=lefd"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("camera.1.view"));
  const Outcome twice = call({"check", "--rig", "four-fake-cameras", "--set", "camera.1.view=front"});
  EXPECT_EQ(twice.code, 2);
  EXPECT_THAT(twice.err, HasSubstr("front has a camera already"));
}

TEST_F(Live, FourCamerasReachAFakeScreenInStep) {
  const Outcome outcome =
      call({"play", "live", "--display", "fake", "--fast-forward", "--seconds", "2", "--set",
            "rig.frame.width=128", "--set", "rig.frame.height=128", "--stats", path("stats.json")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto stats = nlohmann::json::parse(read_text(folder_ / "stats.json"));
  EXPECT_EQ(stats["frames_presented"], 120);
  EXPECT_EQ(stats["pixel_bytes_copied"], 0);
  EXPECT_EQ(stats["heap_allocations"], 0);
  EXPECT_GE(stats["live"]["whole_sets"], 118);
  EXPECT_EQ(stats["live"]["cameras"].size(), 4U);
  EXPECT_LE(stats["live"]["latency_ms_max"], 25.0);
}

TEST_F(Live, FramesGoOutInNv12WhereTheRigSaysSoAndTheDisplayTakesIt) {
  const auto play = [&](const std::vector<std::string>& display, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {"play", "live", "--seconds", "1", "--stats", path("stats.json")};
    for (const char* line : {"rig.frame.width=64", "rig.frame.height=64", "rig.display.format=\"NV12\""}) {
      words.insert(words.end(), {"--set", line});
    }
    words.insert(words.end(), display.begin(), display.end());
    words.insert(words.end(), more.begin(), more.end());
    return call(words);
  };
  const auto stats = [&] { return nlohmann::json::parse(read_text(folder_ / "stats.json")); };
  ASSERT_EQ(play({"--display", "fake", "--fast-forward"}).code, 0);
  EXPECT_GE(stats()["frames_nv12"], 55);
  EXPECT_EQ(stats()["pixel_bytes_copied"], 0);
  const Outcome file = play({"--display", "file", "--out", path("a.y4m")});
  ASSERT_EQ(file.code, 0) << file.err;
  EXPECT_THAT(file.err, HasSubstr("the display takes no NV12: frames are XRGB8888"));
  EXPECT_EQ(stats()["frames_nv12"], 0);
  const Outcome locked =
      play({"--display", "fake", "--fast-forward"}, {"--set", "rig.camera.0.gains=[1.1, 1.0, 1.0]"});
  EXPECT_NE(locked.code, 0);
  EXPECT_THAT(locked.err, HasSubstr("display.format: expected XRGB8888, as colours are matched or locked"));
  const Outcome wrong = play({"--display", "fake"}, {"--set", "rig.display.format=\"NV21\""});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("display.format: expected XRGB8888 or NV12"));
}

TEST_F(Live, WhatCamerasSentIsPlayedAgain) {
  const std::vector<std::string> small = {"--set", "rig.frame.width=64", "--set", "rig.frame.height=64"};
  const auto play = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"play", "live"});
    words.insert(words.end(), small.begin(), small.end());
    return call(words);
  };
  const Outcome recorded =
      play({"--display", "file", "--out", path("a.y4m"), "--seconds", "1", "--record", path("r")});
  ASSERT_EQ(recorded.code, 0) << recorded.err;
  const Outcome replayed =
      play({"--display", "file", "--out", path("b.y4m"), "--seconds", "1", "--replay", path("r")});
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_EQ(read_text(folder_ / "a.y4m"), read_text(folder_ / "b.y4m"));

  std::filesystem::resize_file(folder_ / "r/left.camera", 500'000);
  const Outcome cut = play({"--display", "fake", "--fast-forward", "--seconds", "1", "--replay", path("r")});
  EXPECT_EQ(cut.code, 0);
  EXPECT_THAT(cut.err, HasSubstr("left.camera: ends in the middle of a record at byte"));
  std::filesystem::remove(folder_ / "r/left.camera");
  const Outcome none = play({"--display", "fake", "--fast-forward", "--seconds", "1", "--replay", path("r")});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, HasSubstr("left.camera: No such file or directory"));
  const Outcome nowhere =
      play({"--display", "fake", "--fast-forward", "--seconds", "1", "--record", "/dev/null/r"});
  EXPECT_EQ(nowhere.code, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("/dev/null/r"));
  const Outcome dead = call({"play", "demo", "--display", "fake", "--seconds", "1", "--record", path("r")});
  EXPECT_EQ(dead.code, 2);
  EXPECT_THAT(dead.err, HasSubstr("--record and --replay are for shows with live cues"));
}

TEST_F(Live, CuesStandAmongOthersAndAreChecked) {
  write_text(folder_ / "mixed.toml",
             "rig = \"four-fake-cameras\"\n"
             "[[cue]]\nname = \"title\"\nsource = \"generated\"\nworld = \"bars\"\nface_size = [64, "
             "64]\nduration_s = 0.5\n"
             "[[cue]]\nname = \"outside\"\nsource = \"live\"\ntransition = \"fade\"\nfade_s = "
             "0.2\nduration_s = 0.5\n");
  const std::vector<std::string> small = {"--set", "rig.frame.width=64", "--set", "rig.frame.height=64"};
  const auto of_mixed = [&](std::vector<std::string> words) {
    words.insert(words.begin() + 1, path("mixed.toml"));
    words.insert(words.end(), small.begin(), small.end());
    return call(words);
  };
  const Outcome played =
      of_mixed({"play", "--display", "fake", "--fast-forward", "--stats", path("mixed.json")});
  ASSERT_EQ(played.code, 0) << played.err;
  const auto stats = nlohmann::json::parse(read_text(folder_ / "mixed.json"));
  EXPECT_EQ(stats["frames_presented"], 60) << "it ends by itself";
  EXPECT_GE(stats["live"]["whole_sets"], 58) << "the cameras do not wait for their cue";
  const Outcome checked = of_mixed({"check"});
  EXPECT_THAT(checked.out, HasSubstr("cue outside: live, 4 cameras; cupola check --rig "));
  const Outcome none = of_mixed({"check", "--rig", "omnimax"});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, HasSubstr("cue outside: is live, but "));
}

TEST_F(Live, ALiveShowWantsCamerasAndTheRightClock) {
  const Outcome real = call({"play", "live", "--display", "fake", "--seconds", "1"});
  EXPECT_EQ(real.code, 1);
  EXPECT_THAT(real.err, HasSubstr("--fast-forward"));
  const Outcome none = call({"play", "live", "--rig", "omnimax", "--display", "fake", "--seconds", "1"});
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, HasSubstr("no view has a camera"));
  const Outcome rendered = call({"render", "live", "--out", path("out"), "--frames", "0-1"});
  EXPECT_EQ(rendered.code, 2);
  EXPECT_THAT(rendered.err, HasSubstr("live can only be played"));
}

}  // namespace
}  // namespace cupola
