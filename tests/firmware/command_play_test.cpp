// cupola play: what it counts, and how it ends.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/firmware/program.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

// Under the address sanitizer: what the desktop libraries leave behind is not ours.
constexpr const char* kDesktopLeaks = "ASAN_OPTIONS=detect_leaks=0";

class Play : public ProgramTest {
 protected:
  Play() {
    write_text(folder_ / "show.toml", R"(rig = "rig.toml"
[[cue]]
name = "moving"
source = "generated"
world = "demo"
face_size = [48, 48]
duration_s = 0.5
[[cue]]
name = "still"
source = "stills"
file = "{view}.png"
duration_s = 0.5
)");
  }
  nlohmann::json stats(std::vector<std::string> more, const Circumstances& circumstances = {}) const {
    more.insert(more.begin(), {"play", path("show.toml"), "--stats", path("stats.json")});
    const Outcome outcome = call(more, circumstances);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return nlohmann::json::parse(read_text(folder_ / "stats.json"));
  }
};

TEST_F(Play, ShowsEveryFrameOfAShowOnce) {
  const nlohmann::json counts = stats({"--display", "fake", "--fast-forward"});
  EXPECT_EQ(counts["frames_presented"], 60);
  EXPECT_EQ(counts["frames_unchanged"], 29) << "the still, but for its first frame";
  EXPECT_EQ(counts["frames_late"], 0);
  EXPECT_EQ(counts["frames_dropped"], 0);
  EXPECT_EQ(counts["frames_failed"], 0);
}

TEST_F(Play, DoesNotAllocateWhilePlaying) {
  for (const char* threads : {"1", "3"}) {
    const nlohmann::json counts = stats({"--display", "fake", "--fast-forward", "--threads", threads});
    EXPECT_EQ(counts["heap_allocations"], 0);
    EXPECT_EQ(counts["heap_allocations_elsewhere"], 0);
    EXPECT_EQ(counts["pixel_bytes_copied"], 0);
  }
}

TEST_F(Play, PlaysAnHourInSecondsWhenFastForwarded) {
  const nlohmann::json counts =
      stats({"--display", "fake", "--fast-forward", "--seconds", "3600", "--set", "cue.1.duration_s=4000"});
  EXPECT_EQ(counts["frames_presented"], 216'000);
  EXPECT_EQ(counts["heap_allocations"], 0);
}

TEST_F(Play, KeepsRealTime) {
  const auto began = std::chrono::steady_clock::now();
  const nlohmann::json counts = stats({"--display", "fake"});
  EXPECT_GE(std::chrono::steady_clock::now() - began, 950ms);
  EXPECT_EQ(counts["frames_presented"].get<int>() + counts["frames_dropped"].get<int>(), 60);
}

TEST_F(Play, StopsAfterSomeSeconds) {
  EXPECT_EQ(stats({"--display", "fake", "--fast-forward", "--seconds", "0.25"})["frames_presented"], 15);
}

TEST_F(Play, WritesFramesToFiles) {
  const nlohmann::json counts = stats({"--display", "file", "--out", path("frames"), "--seconds", "0.1"});
  EXPECT_EQ(counts["frames_presented"], 6);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path("frames")), {}), 6);
  EXPECT_EQ(call({"render", path("show.toml"), "--frames", "0-5", "--out", path("rendered")}).code, 0);
  for (const char* name : {"/show_000001.png", "/show_000006.png"}) {
    EXPECT_EQ(read_text(path("frames") + name), read_text(path("rendered") + name));
  }
}

TEST_F(Play, WritesAVideoToAFileOrAPipe) {
  EXPECT_EQ(call({"render", path("show.toml"), "--frames", "0-5", "--out", path("rendered.y4m")}).code, 0);
  const Outcome file =
      call({"play", path("show.toml"), "--display", "file", "--seconds", "0.1", "--out", path("played.y4m")});
  EXPECT_EQ(file.code, 0) << file.err;
  const Outcome pipe =
      call({"play", path("show.toml"), "--display", "file", "--seconds", "0.1", "--out", "-"});
  EXPECT_EQ(pipe.code, 0) << pipe.err;
  const std::string rendered = read_text(path("rendered.y4m"));
  EXPECT_GT(rendered.size(), 1000U);
  EXPECT_TRUE(read_text(path("played.y4m")) == rendered);
  EXPECT_TRUE(pipe.out == rendered);
}

TEST_F(Play, EndsOnCtrlC) {
  const nlohmann::json counts =
      stats({"--display", "fake", "--set", "cue.1.duration_s=1000"}, {.meanwhile = [](pid_t child) {
              std::this_thread::sleep_for(1500ms);
              kill(child, SIGINT);
            }});
  EXPECT_GT(counts["frames_presented"], 0);
}

TEST_F(Play, OpensAWindow) {
  EXPECT_EQ(stats({"--display", "window", "--seconds", "0.2"},
                  {.environment = {"SDL_VIDEODRIVER=dummy", kDesktopLeaks}})["display"],
            "window");
}

TEST_F(Play, RefusesDisplaysThatAreNot) {
  expect_refusal({"play", path("show.toml"), "--display", "auto"}, 1,
                 {"there is no desktop", "--display fake"},
                 {.environment = {"DISPLAY=", "WAYLAND_DISPLAY="}});
  expect_refusal({"play", path("show.toml"), "--display", "window"}, 1, {"window: "},
                 {.environment = {"SDL_VIDEODRIVER=x11", "DISPLAY=:987", kDesktopLeaks}});
  expect_refusal({"play", path("show.toml"), "--display", "file"}, 2, {"--out"});
  expect_refusal({"play", path("show.toml"), "--display", "window", "--fast-forward"}, 2, {"--fast-forward"});
}

TEST_F(Play, FailsWhenFramesCannotBeWritten) {
  expect_refusal({"play", path("show.toml"), "--display", "file", "--out", path("front.png/x")}, 1,
                 {path("front.png/x"), "Not a directory"});
}

TEST_F(Play, GoesOnWithTheLastGoodFrameWhenAPictureIsDamaged) {
  for (const char* view : {"front", "left", "right", "top"}) {
    for (int number = 1; number <= 9; ++number) {
      std::filesystem::copy_file(path(std::string(view) + ".png"),
                                 path(std::string(view) + "_" + std::to_string(number) + ".png"));
    }
  }
  write_text(folder_ / "left_5.png", "no picture");
  write_text(folder_ / "left_6.png", "no picture");
  write_text(folder_ / "show.toml",
             "rig = \"rig.toml\"\n[[cue]]\nname = \"a\"\nsource = \"sequence\"\nfile = \"{view}_%d.png\"\n");
  const Outcome outcome =
      call({"play", path("show.toml"), "--display", "fake", "--fast-forward", "--stats", path("stats.json")});
  EXPECT_EQ(outcome.code, 0);
  const nlohmann::json counts = nlohmann::json::parse(read_text(path("stats.json")));
  EXPECT_EQ(counts["frames_presented"], 9);
  EXPECT_EQ(counts["frames_failed"], 2);
  EXPECT_THAT(outcome.err, HasSubstr("left_5.png"));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 2)
      << "lost once, back once: " << outcome.err;
}

}  // namespace
}  // namespace cupola
