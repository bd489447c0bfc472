// Outputs that cannot be written, readers that go away, and Ctrl-C: exit code 1, a reason, nothing half
// written.
// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <string>
#include <thread>

#include "pipeline/frame/still.h"
#include "tests/firmware/program.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;

class BadOutput : public ProgramTest {
 protected:
  std::vector<std::string> warp_to(const std::string& out) const {
    std::vector<std::string> arguments = warp_arguments();
    arguments[4] = out;
    return arguments;
  }
  std::vector<std::string> render_to(const std::string& out, const std::string& frames = "0-5") const {
    return {"render", "--rig",    path("rig.toml"), "--world", "demo", "--face-size",
            "48",     "--frames", frames,           "--out",   out};
  }
  static Circumstances with_small_disk() {
    return {.in_child = [] {
      const rlimit limit{2000, 2000};
      setrlimit(RLIMIT_FSIZE, &limit);
    }};
  }
};

TEST_F(BadOutput, BelowAFile) {
  expect_refusal(warp_to(path("front.png/frame.png")), 1, {path("front.png/frame.png"), "Not a directory"});
  expect_refusal(render_to(path("front.png/frames")), 1, {path("front.png/frames"), "Not a directory"});
  expect_refusal(render_to(path("front.png/video.y4m")), 1, {path("front.png/video.y4m"), "Not a directory"});
}

TEST_F(BadOutput, InAFolderThatIsNotThere) {
  expect_refusal(warp_to(path("none/frame.png")), 1, {path("none/frame.png"), "No such file"});
}

TEST_F(BadOutput, InAFolderThatCannotBeWrittenTo) {
  expect_refusal(warp_to("/proc/frame.png"), 1, {"/proc/frame.png"});
  expect_refusal(render_to("/proc/frames"), 1, {"/proc/frames"});
}

TEST_F(BadOutput, IsAFolder) {
  expect_refusal(warp_to(folder_.path().string()), 1, {folder_.path().string()});
}

TEST_F(BadOutput, OfAKindThatIsNotWritten) {
  expect_refusal(warp_to(path("frame.jpg")), 2, {path("frame.jpg"), "ends in .png"});
}

TEST_F(BadOutput, OnAFullDisk) {
  expect_refusal(warp_to(path("frame.png")), 1, {path("frame.png"), "File too large"}, with_small_disk());
  expect_refusal(render_to(path("video.y4m")), 1, {path("video.y4m"), "File too large"}, with_small_disk());
  expect_refusal(warp_to("/dev/full"), 1, {"/dev/full", "No space left"});
  expect_refusal(warp_arguments({"--out", "/dev/full"}), 2, {"--out"});
  std::filesystem::create_symlink("/dev/full", path("full.y4m"));
  expect_refusal(render_to(path("full.y4m")), 1, {path("full.y4m"), "No space left"});
}

TEST_F(BadOutput, OnAFullDiskWithNumberedFiles) {
  std::filesystem::create_directory(path("frames"));
  const std::string kept = path("frames") + "/kept.txt";
  write_text(kept, "mine");
  expect_refusal(render_to(path("frames")), 1, {path("frames"), "File too large"}, with_small_disk());
  EXPECT_EQ(read_text(kept), "mine");
  for (const auto& entry : std::filesystem::directory_iterator(path("frames")))
    EXPECT_TRUE(entry.path() == kept || entry.path().extension() == ".render") << entry.path();
}

TEST_F(BadOutput, FullDiskLeavesTheOldFrame) {
  EXPECT_EQ(call(warp_arguments()).code, 0);
  const std::string old = read_text(path("frame.png"));
  expect_refusal(warp_to(path("frame.png")), 1, {path("frame.png")}, with_small_disk());
  EXPECT_EQ(read_text(path("frame.png")), old);
}

TEST_F(BadOutput, PipeThatIsFull) {
  expect_refusal(render_to("-"), 1, {"standard output", "No space left"},
                 {.in_child = [] { dup2(open("/dev/full", O_WRONLY), 1); }});
}

TEST_F(BadOutput, PipeWhoseReaderGoesAway) {
  expect_refusal(render_to("-", "0-500"), 1, {"standard output", "Broken pipe"}, {.read_output = false});
}

TEST_F(BadOutput, StatsThatCannotBeWritten) {
  const Outcome outcome = call(warp_arguments({"--stats", path("front.png/stats.json")}));
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, testing::HasSubstr(path("front.png/stats.json")));
}

class Interrupt : public BadOutput {
 protected:
  // Sends `signal` once `ready` is there, at the latest after some seconds.
  static Circumstances when(const std::string& ready, int signal) {
    return {.meanwhile = [=](pid_t child) {
      for (int i = 0; i < 2000 && !std::filesystem::exists(ready); ++i) std::this_thread::sleep_for(5ms);
      kill(child, signal);
    }};
  }
  // Some time after the program has begun to catch it: until then Ctrl-C ends any program at once.
  static void interrupt(pid_t child) {
    for (int i = 0; i < 2000 && !catches(child, SIGINT); ++i) std::this_thread::sleep_for(5ms);
    std::this_thread::sleep_for(300ms);
    kill(child, SIGINT);
  }

 private:
  static bool catches(pid_t process, int signal) {
    std::ifstream status("/proc/" + std::to_string(process) + "/status");
    for (std::string line; std::getline(status, line);) {
      if (!line.starts_with("SigCgt:")) continue;
      return (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1) != 0;
    }
    return false;
  }
};

TEST_F(Interrupt, EndsARenderBetweenFrames) {
  for (const int signal : {SIGINT, SIGTERM}) {
    std::filesystem::remove_all(path("frames"));
    const Outcome outcome =
        call(render_to(path("frames"), "0-100000"), when(path("frames") + "/rig_000003.png", signal));
    EXPECT_EQ(outcome.code, 1);
    EXPECT_THAT(outcome.err, testing::HasSubstr(path("frames")));
    EXPECT_THAT(outcome.err, testing::HasSubstr("interrupted"));
    for (const auto& entry : std::filesystem::directory_iterator(path("frames"))) {
      if (entry.path().extension() == ".render") continue;  // so that it can go on
      EXPECT_EQ(entry.path().extension(), ".png");
      EXPECT_NO_THROW(read_still(entry.path())) << entry.path();
    }
  }
}

TEST_F(Interrupt, LeavesNoHalfVideo) {
  expect_refusal(render_to(path("video.y4m"), "0-100000"), 1, {path("video.y4m"), "interrupted"},
                 {.meanwhile = interrupt});
}

TEST_F(Interrupt, EndsAWarpBetweenRepeats) {
  std::vector<std::string> arguments = warp_arguments({"--repeat", "1000000000", "--method", "ewa-exact"});
  expect_refusal(arguments, 1, {path("frame.png"), "interrupted"}, {.meanwhile = interrupt});
}

}  // namespace
}  // namespace cupola
