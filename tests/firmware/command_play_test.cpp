// cupola play: what it counts, and how it ends.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "pipeline/frame/still.h"
#include "tests/firmware/program.h"
#include "tests/hal/sanitized.h"

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

TEST_F(Play, WritesAllThatHappensAsJsonIfAsked) {
  const std::vector<std::string> play = {"play", path("show.toml"), "--display", "fake", "--fast-forward"};
  EXPECT_EQ(call(play).err, "") << "an operator need not know";
  std::vector<std::string> as_json = play;
  as_json.insert(as_json.end(), {"--log", "json"});
  const Outcome outcome = call(as_json);
  EXPECT_EQ(outcome.code, 0);
  std::istringstream lines(outcome.err);
  std::vector<std::string> texts;
  for (std::string line; std::getline(lines, line);)
    texts.push_back(nlohmann::json::parse(line)["text"].get<std::string>());
  EXPECT_THAT(texts, testing::ElementsAre("playing", "cue 2", "over"));
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

TEST_F(Play, FadesAsItIsRendered) {
  const std::vector<std::string> faded = {"--set", "cue.1.transition=fade", "--set", "cue.1.fade_s=0.4",
                                          "--set", "cue.0.transition=fade", "--set", "cue.0.fade_s=0.1"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.end(), faded.begin(), faded.end());
    return more;
  };
  const nlohmann::json counts = stats(with({"--display", "file", "--out", path("played"), "--seconds", "1"}));
  EXPECT_EQ(counts["frames_presented"], 60);
  EXPECT_EQ(stats(with({"--display", "fake", "--fast-forward"}))["heap_allocations"], 0);
  EXPECT_EQ(call(with({"render", path("show.toml"), "--out", path("rendered")})).code, 0);
  EXPECT_EQ(call({"render", path("show.toml"), "--out", path("cut")}).code, 0);
  int differ = 0;
  for (int number = 1; number <= 60; ++number) {
    const std::string name =
        "/show_0000" + std::string(number < 10 ? "0" : "") + std::to_string(number) + ".png";
    const std::string rendered = read_text(path("rendered") + name);
    EXPECT_TRUE(read_text(path("played") + name) == rendered) << name;
    differ += rendered == read_text(path("cut") + name) ? 0 : 1;
  }
  EXPECT_EQ(differ, 6 + 24);
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
      stats({"--display", "fake", "--set", "cue.1.duration_s=1000", "--resume", path("position")},
            {.meanwhile = [&](pid_t child) {
              for (int turn = 0; turn < 2000 && !std::filesystem::exists(path("position")); ++turn)
                std::this_thread::sleep_for(10ms);
              kill(child, SIGINT);
            }});
  EXPECT_GT(counts["frames_presented"], 0);
}

// Root's rights are taken from it as well: those would lift the limits.
TEST_F(Play, SaysWhatTheMachineRefusesAndPlaysOn) {
  const auto in_child = [] {
    for (const int right : {CAP_SYS_NICE, CAP_IPC_LOCK}) prctl(PR_CAPBSET_DROP, right, 0, 0, 0);
    const rlimit none{0, 0};
    setrlimit(RLIMIT_RTPRIO, &none);
    setrlimit(RLIMIT_MEMLOCK, &none);
  };
  const Outcome outcome = call({"play", path("show.toml"), "--display", "fake", "--seconds", "0.2", "--set",
                                "machine={priority=50, lock_memory=true, cores=[0, 1023]}", "--threads", "2"},
                               {.in_child = in_child});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("cupola: machine.cores: core 1023 is not to be had"));
  EXPECT_THAT(outcome.err, HasSubstr("cupola: machine.priority: 50 is refused: Operation not permitted"));
  // The address and thread sanitizers lock nothing, and say that it went well.
  if (!test::kSanitized) {
    EXPECT_THAT(outcome.err, HasSubstr("cupola: machine.lock_memory: refused: "));
  }
  expect_refusal({"play", path("show.toml"), "--display", "fake", "--set", "machine.priority=100"}, 2,
                 {"machine.priority", "from 0 to 99"});
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

#ifdef CUPOLA_HTTP
TEST_F(Play, RefusesToListenToOthersWithoutAToken) {
  const std::vector<std::string> play = {"play", path("show.toml"), "--display", "fake", "--http"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), play.begin(), play.end());
    return more;
  };
  expect_refusal(with({"0.0.0.0:8080"}), 2, {"--http 0.0.0.0:8080", "--token-file"});
  expect_refusal(with({"here"}), 2, {"--http \"here\"", "127.0.0.1:8080"});
  expect_refusal(with({"0.0.0.0:0", "--token-file", path("none")}), 2, {path("none"), "token"});
  write_text(folder_ / "token", "short\n");
  expect_refusal(with({"0.0.0.0:0", "--token-file", path("token")}), 2, {path("token") + ":1", "16"});
  expect_refusal({"play", path("show.toml"), "--display", "fake", "--set", "control.http=\"0.0.0.0:80\""}, 2,
                 {"control.http: expected a token_file"});
  const std::vector<std::string> osc = {"play", path("show.toml"), "--display",
                                        "fake", "--osc",           "0.0.0.0:9000"};
  expect_refusal(osc, 2, {"--osc 0.0.0.0:9000", "--token-file"});
  expect_refusal({"play", path("show.toml"), "--display", "fake", "--set", "control.osc=\"0.0.0.0:80\""}, 2,
                 {"control.osc: expected a token_file"});
  expect_refusal({"status", "--http", "127.0.0.1:1"}, 1, {"127.0.0.1:1: no player answers"});
}

TEST_F(Play, SaysWhereItListensAndAnswersThere) {
  Circumstances circumstances;
  Outcome status;
  circumstances.meanwhile = [&](pid_t child) {
    for (int turn = 0; turn < 600 && status.out.find("playing") == std::string::npos; ++turn) {
      std::this_thread::sleep_for(50ms);
      status = call({"status", "--http", "127.0.0.77:24765"});
    }
    kill(child, SIGINT);
  };
  const Outcome outcome = call({"play", path("show.toml"), "--display", "fake", "--set",
                                "cue.0.duration_s=1000", "--http", "127.0.0.77:24765"},
                               circumstances);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "cupola: control at http://127.0.0.77:24765/\n");
  EXPECT_EQ(status.code, 0) << status.err;
  EXPECT_THAT(status.out, HasSubstr("show: playing"));
  EXPECT_THAT(status.out, HasSubstr("fake, 60.00 Hz"));
}
#endif

TEST_F(Play, FailsWhenFramesCannotBeWritten) {
  expect_refusal({"play", path("show.toml"), "--display", "file", "--out", path("front.png/x")}, 1,
                 {path("front.png/x"), "Not a directory"});
}

TEST_F(Play, DecodesSequencesAheadAndAllocatesNothingInTheLoop) {
  for (const char* view : {"front", "left", "right", "top"}) {
    for (int number = 1; number <= 30; ++number) {
      const std::string file = path(std::string(view) + "_" + std::to_string(number) + ".png");
      write_png(
          file,
          noise_picture(PixelFormat::kRgbPlanar8, {48, 48}, static_cast<std::uint32_t>(number)).pixels());
    }
  }
  write_text(folder_ / "show.toml", R"(rig = "rig.toml"
[[cue]]
name = "a"
source = "sequence"
file = "{view}_%d.png"
loop = true
duration_s = 0.75
[[cue]]
name = "b"
source = "sequence"
file = "{view}_%d.png"
in = 11
rate = 30
)");
  const nlohmann::json counts = stats({"--display", "fake", "--fast-forward"});
  EXPECT_EQ(counts["frames_presented"], 45 + 40);
  EXPECT_EQ(counts["frames_unchanged"], 20) << "each of b's is shown twice";
  EXPECT_EQ(counts["heap_allocations"], 0);
  EXPECT_GE(counts["files"]["frames_decoded"], 45 + 20);
  EXPECT_EQ(counts["files"]["frames_late"], 0);
  EXPECT_EQ(counts["files"]["frames_broken"], 0);
  const nlohmann::json in_time = stats({"--display", "fake"});
  EXPECT_EQ(in_time["heap_allocations"], 0);
  EXPECT_EQ(in_time["frames_failed"], 0);
  // What is presented is what `render` makes, to the bit.
  stats({"--display", "file", "--out", path("played.y4m")});
  EXPECT_EQ(call({"render", path("show.toml"), "--out", path("rendered.y4m")}).code, 0);
  EXPECT_TRUE(read_text(path("played.y4m")) == read_text(path("rendered.y4m")));
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
  EXPECT_EQ(counts["files"]["frames_broken"], 2);
  EXPECT_THAT(outcome.err, HasSubstr("left_5.png"));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 2)
      << "lost once, back once: " << outcome.err;
}

}  // namespace
}  // namespace cupola
