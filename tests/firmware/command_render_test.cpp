// cupola render: which files, which frames, which bytes.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "pipeline/frame/still.h"
#include "pipeline/frame/y4m_reader.h"
#include "tests/firmware/program.h"

namespace cupola {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Render : public ProgramTest {
 protected:
  Render() {
    write_text(folder_ / "show.toml", R"(rig = "rig.toml"

[[cue]]
name = "moving"
source = "generated"
world = "demo"
face_size = [48, 48]
rate = 10
duration_s = 0.5

[[cue]]
name = "still"
source = "stills"
file = "{view}.png"
rate = 10
duration_s = 0.3
)");
  }
  Outcome render(const std::string& out, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"render", path("show.toml"), "--out", path(out)});
    return call(more);
  }
  std::vector<std::string> files(const std::string& folder) const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path(folder)))
      if (!entry.path().filename().string().starts_with(".")) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }
};

TEST_F(Render, DoesNotWaitForAnOperator) {
  EXPECT_EQ(render("plain").code, 0);
  EXPECT_EQ(render("waits", {"--set", "cue.0.then=wait", "--set", "cue.1.then=wait"}).code, 0);
  EXPECT_EQ(files("waits"), files("plain"));
}

TEST_F(Render, NumbersFilesFromOneAndFramesFromZero) {
  EXPECT_EQ(render("all").code, 0);
  EXPECT_THAT(files("all"),
              ElementsAre("show_000001.png", "show_000002.png", "show_000003.png", "show_000004.png",
                          "show_000005.png", "show_000006.png", "show_000007.png", "show_000008.png"));
  EXPECT_EQ(render("some", {"--frames", "3-5"}).code, 0);
  EXPECT_THAT(files("some"), ElementsAre("show_000004.png", "show_000005.png", "show_000006.png"));
  for (const std::string& name : files("some"))
    EXPECT_EQ(read_text(path("some/" + name)), read_text(path("all/" + name)));
}

TEST_F(Render, CutsFromCueToCue) {
  EXPECT_EQ(render("all").code, 0);
  EXPECT_NE(read_text(path("all/show_000004.png")), read_text(path("all/show_000005.png"))) << "it moves";
  EXPECT_NE(read_text(path("all/show_000005.png")), read_text(path("all/show_000006.png")));
  EXPECT_EQ(read_text(path("all/show_000006.png")), read_text(path("all/show_000008.png"))) << "it stands";
  EXPECT_EQ(call(warp_arguments()).code, 0);
  EXPECT_EQ(read_text(path("all/show_000006.png")), read_text(path("frame.png")))
      << "what warp makes of the stills";
}

TEST_F(Render, GivesEqualBytesForAnyThreadsAndShards) {
  EXPECT_EQ(render("one", {"--threads", "1"}).code, 0);
  EXPECT_EQ(render("three", {"--threads", "3"}).code, 0);
  EXPECT_EQ(render("shards", {"--shard", "1/2"}).code, 0);
  EXPECT_EQ(files("shards").size(), 4U);
  EXPECT_EQ(render("shards", {"--shard", "2/2"}).code, 0);
  EXPECT_EQ(files("shards"), files("one"));
  for (const std::string& name : files("one")) {
    EXPECT_EQ(read_text(path("three/" + name)), read_text(path("one/" + name)));
    EXPECT_EQ(read_text(path("shards/" + name)), read_text(path("one/" + name)));
  }
}

TEST_F(Render, WritesTheFacesToo) {
  EXPECT_EQ(render("faces", {"--frames", "5-5", "--faces"}).code, 0);
  EXPECT_THAT(files("faces"), ElementsAre("show_000006.png", "show_front_000006.png", "show_left_000006.png",
                                          "show_right_000006.png", "show_top_000006.png"));
  const ImageBuffer given = read_still(path("left.png"));
  const ImageBuffer written = read_still(path("faces/show_left_000006.png"));
  EXPECT_EQ(largest_difference(given.pixels(), written.pixels()), 0);
}

TEST_F(Render, WritesAVideo) {
  EXPECT_EQ(render("show.y4m").code, 0);
  Y4mReader video(path("show.y4m"));
  EXPECT_EQ(video.size(), (Size{96, 70}));
  EXPECT_EQ(video.frames(), 8);
  EXPECT_EQ(video.header().rate.numerator, 10);
}

TEST_F(Render, WritesTheSameVideoDownAPipe) {
  EXPECT_EQ(render("show.y4m").code, 0);
  const Outcome outcome = call({"render", path("show.toml"), "--out", "-"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out, read_text(path("show.y4m")));
  EXPECT_EQ(outcome.err, "") << "no progress bar without a terminal";
}

TEST_F(Render, IsReadByFfmpeg) {
  const std::string command = std::string(CUPOLA_PROGRAM) + " render " + path("show.toml") +
                              " --out - | ffmpeg -v error -i - -f framemd5 " + path("sums.txt");
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string sums = read_text(path("sums.txt"));
  std::int64_t frames = 0;
  for (std::size_t at = sums.find("\n0,"); at != std::string::npos; at = sums.find("\n0,", at + 1)) ++frames;
  EXPECT_EQ(frames, 8) << sums;
}

TEST_F(Render, WritesVideosOfTenBits) {
  const Outcome outcome =
      call({"render", path("show.toml"), "--out", path("a.y4m"), "--frames", "0-1", "--bits", "10"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  Y4mReader video(path("a.y4m"));
  EXPECT_EQ(video.frames(), 2);
  EXPECT_THAT(read_text(path("a.y4m")).substr(0, 100), HasSubstr(" C444p10 "));
  expect_refusal({"render", path("show.toml"), "--out", path("out"), "--bits", "10"}, 2,
                 {"--bits 10", "y4m"});
  expect_refusal({"render", path("show.toml"), "--out", path("b.y4m"), "--bits", "16"}, 2,
                 {"--bits 16", "8 or 10"});
}

TEST_F(Render, GoesOnWhereItWasKilledAndLeavesNothingElse) {
  const std::vector<std::string> longer = {"--set", "cue.0.duration_s=12"};
  EXPECT_EQ(render("whole", longer).code, 0);
  std::vector<std::string> arguments = {"render", path("show.toml"), "--out", path("killed")};
  arguments.insert(arguments.end(), longer.begin(), longer.end());
  for (const char* until : {"show_000005.png", "show_000040.png", "show_000077.png"}) {
    const Outcome outcome =
        call(arguments, {.meanwhile = [&](pid_t child) {
               for (int turn = 0; turn < 20'000 && !std::filesystem::exists(path("killed/") + until); ++turn)
                 std::this_thread::sleep_for(std::chrono::milliseconds(1));
               kill(child, SIGKILL);
             }});
    ASSERT_EQ(outcome.code, 128 + SIGKILL);
  }
  ASSERT_TRUE(std::filesystem::exists(path("killed/.show.1-1.render")));
  write_text(folder_ / "killed" / "show_000003.png", "cut short by somebody");
  const auto kept = std::filesystem::last_write_time(path("killed/show_000002.png"));
  const Outcome outcome = call(arguments);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr(" of 123 frames are there; going on"),
                                          testing::Not(HasSubstr(": 0 of"))));
  EXPECT_EQ(std::filesystem::last_write_time(path("killed/show_000002.png")), kept);
  EXPECT_EQ(files("killed"), files("whole"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path("killed")), {}), 123)
      << "neither its state nor temporary files are left";
  for (const std::string& name : files("whole"))
    EXPECT_TRUE(read_text(path("killed/" + name)) == read_text(path("whole/" + name))) << name;
}

#ifdef CUPOLA_EXR
TEST_F(Render, WritesExrOfTheSameFrames) {
  EXPECT_EQ(render("pictures", {"--frames", "3-4", "--bits", "16"}).code, 0);
  const Outcome outcome = render("light", {"--frames", "3-4", "--format", "exr"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(files("light"), (std::vector<std::string>{"show_000004.exr", "show_000005.exr"}));
  const ImageBuffer picture = read_still(path("pictures/show_000004.png"));
  const ImageBuffer light = read_still(path("light/show_000004.exr"));
  ASSERT_EQ(picture.size(), light.size());
  for (int y = 0; y < picture.size().height; ++y) {
    for (int x = 0; x < picture.size().width; ++x) {
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(sample(picture, c, x, y), sample(light, c, x, y), 10);
    }
  }
  expect_refusal({"render", path("show.toml"), "--out", path("a.y4m"), "--format", "exr"}, 2,
                 {"--format exr"});
  expect_refusal({"render", path("show.toml"), "--out", path("out"), "--format", "exr", "--bits", "8"}, 2,
                 {"--bits 8"});
}
#endif

TEST_F(Render, TakesNoFramesOfAnotherRender) {
  const auto kill_early = [&](std::vector<std::string> more) {
    more.insert(more.begin(),
                {"render", path("show.toml"), "--out", path("out"), "--set", "cue.0.duration_s=12"});
    const Outcome outcome = call(
        more, {.meanwhile = [&](pid_t child) {
          for (int turn = 0; turn < 20'000 && !std::filesystem::exists(path("out/show_000009.png")); ++turn)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
          kill(child, SIGKILL);
        }});
    EXPECT_EQ(outcome.code, 128 + SIGKILL);
    EXPECT_THAT(outcome.err, testing::Not(HasSubstr("going on")));
    std::filesystem::remove(path("out/show_000009.png"));
  };
  kill_early({});
  kill_early({"--set", "rig.tilt_deg=5"});
  kill_early({"--set", "cue.0.world=grid"});
  write_text(folder_ / "left.png", read_text(path("right.png")));
  kill_early({"--set", "cue.0.world=grid"});
}

TEST_F(Render, DoesWithoutAShow) {
  const Outcome outcome = call(
      {"render", "--rig", path("rig.toml"), "--world", "grid", "--face-size", "48", "--out", path("grid")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(files("grid"), ElementsAre("rig_000001.png"));
}

TEST_F(Render, TakesAnotherRig) {
  write_rig("small.toml", "width = 96", "width = 64");
  EXPECT_EQ(render("other", {"--rig", path("small.toml"), "--frames", "0"}).code, 0);
  EXPECT_EQ(probe_still(path("other/show_000001.png")).size, (Size{64, 70}));
  EXPECT_EQ(render("set", {"--set", "rig.frame.width=32", "--set", "cue.0.world=grid", "--frames", "0"}).code,
            0);
  EXPECT_EQ(probe_still(path("set/show_000001.png")).size, (Size{32, 70}));
}

TEST_F(Render, RefusesFramesThatAreNone) {
  for (const char* frames : {"5-4", "-1-3", "a-b", "3-", "0-8", "99", "1-2-3", ""}) {
    expect_refusal({"render", path("show.toml"), "--out", path("no"), "--frames=" + std::string(frames)}, 2,
                   {"--frames"});
  }
  for (const char* shard : {"0/2", "3/2", "1", "1/0", "x/y"}) {
    expect_refusal({"render", path("show.toml"), "--out", path("no"), "--shard", shard}, 2,
                   {"--shard", shard});
  }
}

TEST_F(Render, RefusesAShowThatNeverEndsUnlessFramesAreGiven) {
  write_text(folder_ / "endless.toml",
             "rig = \"rig.toml\"\n[[cue]]\nname = \"a\"\nsource = \"stills\"\nfile = \"{view}.png\"\n");
  expect_refusal({"render", path("endless.toml"), "--out", path("no")}, 2,
                 {path("endless.toml"), "never ends", "--frames"});
  EXPECT_EQ(call({"render", path("endless.toml"), "--out", path("yes"), "--frames", "0-1"}).code, 0);
}

TEST_F(Render, RefusesADamagedPictureOfASequenceByName) {
  for (const char* view : {"front", "left", "right", "top"}) {
    for (const char* number : {"1", "2", "3"}) {
      std::filesystem::copy_file(path(std::string(view) + ".png"),
                                 path(std::string(view) + "_" + number + ".png"));
    }
  }
  write_text(folder_ / "sequence.toml",
             "rig = \"rig.toml\"\n[[cue]]\nname = \"a\"\nsource = \"sequence\"\nfile = "
             "\"{view}_%d.png\"\nrate = 10\n");
  EXPECT_EQ(call({"render", path("sequence.toml"), "--out", path("good")}).code, 0);
  EXPECT_EQ(files("good").size(), 3U);
  write_text(folder_ / "left_3.png", read_text(path("left_3.png")).substr(0, 1000));
  const Outcome outcome = call({"render", path("sequence.toml"), "--out", path("bad"), "--threads", "1"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("left_3.png"));
  EXPECT_THAT(files("bad"), ElementsAre("sequence_000001.png", "sequence_000002.png"));
}

}  // namespace
}  // namespace cupola
