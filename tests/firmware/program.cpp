// fork and exec, two pipes and a deadline.
// SPDX-License-Identifier: MIT
#include "tests/firmware/program.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>

#include "pipeline/frame/still.h"

namespace cupola {
namespace {

constexpr std::string_view kRig = R"(views = "axis"

[frame]
width = 96
height = 70
center = [48.0, 48.0]
radius = 48.0

[lens]
model = "omnimax-c430"

[[view]]
name = "front"

[[view]]
name = "left"

[[view]]
name = "right"

[[view]]
name = "top"
)";

}  // namespace

Outcome call(const std::vector<std::string>& arguments, const Circumstances& circumstances) {
  std::vector<char*> words = {const_cast<char*>(CUPOLA_PROGRAM)};
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  std::array<int, 2> out{};
  std::array<int, 2> err{};
  EXPECT_EQ(pipe2(out.data(), O_CLOEXEC), 0);
  EXPECT_EQ(pipe2(err.data(), O_CLOEXEC), 0);
  const pid_t child = fork();
  if (child == 0) {
    dup2(out[1], 1);
    dup2(err[1], 2);
    const int none = open("/dev/null", O_RDONLY);
    dup2(none, 0);
    setenv("CUPOLA_CACHE", "off", 1);  // unless a test says otherwise
    for (const std::string& line : circumstances.environment) putenv(const_cast<char*>(line.c_str()));
    circumstances.in_child();
    execv(CUPOLA_PROGRAM, words.data());
    _exit(127);
  }
  close(out[1]);
  close(err[1]);
  if (!circumstances.read_output) close(out[0]);
  circumstances.meanwhile(child);

  Outcome outcome;
  std::array<pollfd, 2> ends = {{{circumstances.read_output ? out[0] : -1, POLLIN, 0}, {err[0], POLLIN, 0}}};
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(240);
  std::array<char, 65536> part{};
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    if (poll(ends.data(), ends.size(), 1000) == 0 && std::chrono::steady_clock::now() > deadline) {
      ADD_FAILURE() << "the program does not end";
      kill(child, SIGKILL);
    }
    for (std::size_t i = 0; i < ends.size(); ++i) {
      if (ends[i].fd < 0 || ends[i].revents == 0) continue;
      const ssize_t count = read(ends[i].fd, part.data(), part.size());
      if (count > 0) {
        (i == 0 ? outcome.out : outcome.err).append(part.data(), static_cast<std::size_t>(count));
      } else {
        close(ends[i].fd);
        ends[i].fd = -1;
      }
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

ProgramTest::ProgramTest() {
  write_text(folder_ / "rig.toml", kRig);
  std::uint32_t seed = 0;
  for (const char* view : {"front", "left", "right", "top"}) {
    const ImageBuffer picture = noise_picture(PixelFormat::kRgb8, {48, 48}, ++seed);
    write_png(folder_ / (std::string(view) + ".png"), picture.pixels());
  }
}

void ProgramTest::write_rig(std::string_view name, std::string_view replaced,
                            std::string_view replacement) const {
  std::string text(kRig);
  const std::size_t at = text.find(replaced);
  ASSERT_NE(at, std::string::npos) << replaced;
  text.replace(at, replaced.size(), replacement);
  write_text(folder_ / name, text);
}

std::vector<std::string> ProgramTest::warp_arguments(std::vector<std::string> more) const {
  std::vector<std::string> arguments = {"warp", "--rig", path("rig.toml"), "--out", path("frame.png")};
  for (const char* view : {"front", "left", "right", "top"}) {
    arguments.emplace_back("--view");
    arguments.push_back(std::string(view) + "=" + path(std::string(view) + ".png"));
  }
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

void ProgramTest::expect_refusal(const std::vector<std::string>& arguments, int code,
                                 const std::vector<std::string>& words,
                                 const Circumstances& circumstances) const {
  const std::vector<std::string> before = folder_.names();
  const Outcome outcome = call(arguments, circumstances);
  EXPECT_EQ(outcome.code, code) << outcome.err;
  for (const std::string& word : words) EXPECT_THAT(outcome.err, testing::HasSubstr(word));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_EQ(outcome.err.find("terminate"), std::string::npos) << outcome.err;
  EXPECT_EQ(folder_.names(), before) << "files left behind";
}

}  // namespace cupola
