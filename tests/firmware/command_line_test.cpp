// The command line: help, version, and calls that are wrong.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <unistd.h>

#include "pipeline/frame/still.h"
#include "pipeline/warp/cpu.h"
#include "tests/firmware/program.h"

namespace cupola {
namespace {

using testing::HasSubstr;

constexpr const char* kCommands[] = {"warp", "render", "play", "table", "check"};

using CommandLine = ProgramTest;

TEST_F(CommandLine, TellsItsVersion) {
  const Outcome outcome = call({"--version"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out.substr(0, 7), "cupola ");
  EXPECT_EQ(outcome.err, "");
}

TEST_F(CommandLine, NamesEveryCommandInItsHelp) {
  const Outcome outcome = call({"--help"});
  EXPECT_EQ(outcome.code, 0);
  for (const char* command : kCommands) EXPECT_THAT(outcome.out, HasSubstr(command));
}

TEST_F(CommandLine, GivesEveryCommandExamplesAndTheCommonOptions) {
  for (const char* command : kCommands) {
    const Outcome outcome = call({command, "--help"});
    EXPECT_EQ(outcome.code, 0);
    for (const char* word : {"Examples:", "--threads", "--cpu", "--set"}) {
      EXPECT_THAT(outcome.out, HasSubstr(word)) << command;
    }
    EXPECT_THAT(outcome.out, HasSubstr(std::string("  cupola ") + command));
  }
}

TEST_F(CommandLine, RefusesWhatItDoesNotKnow) {
  expect_refusal({}, 2, {"cupola: "});
  expect_refusal({"wrap"}, 2, {"cupola wrap: no such command; did you mean warp?"});
  expect_refusal(warp_arguments({"--nonsense"}), 2, {"--nonsense"});
  expect_refusal(warp_arguments({"--threads", "0"}), 2, {"--threads"});
  expect_refusal(warp_arguments({"--threads", "many"}), 2, {"--threads", "many"});
  expect_refusal(warp_arguments({"--repeat", "0"}), 2, {"--repeat"});
  expect_refusal(warp_arguments({"--method", "ewa-scam"}), 2,
                 {"--method ewa-scam", "did you mean ewa-scan?"});
  expect_refusal(warp_arguments({"--cpu", "z80"}), 2, {"--cpu z80", "scalar"});
  const std::string foreign(name(supported(Cpu::kNeon) ? Cpu::kAvx2 : Cpu::kNeon));
  expect_refusal(warp_arguments({"--cpu", foreign}), 2,
                 {"--cpu " + foreign, "this machine does not have it"});
  expect_refusal({"warp", "--rig", path("rig.toml"), "--world", "demo"}, 2, {"--out"});
  expect_refusal({"play", "demo", "--display", "wall"}, 2, {"--display", "wall"});
  expect_refusal({"check"}, 2, {"expected a show or --rig"});
  expect_refusal({"render", "--out", path("frames")}, 2, {"expected a show, or --rig"});
}

TEST_F(CommandLine, LaysValuesOverTheRig) {
  EXPECT_EQ(call(warp_arguments({"--set", "frame.width=64", "--set", "lens.model=equidistant"})).code, 0);
  EXPECT_EQ(probe_still(path("frame.png")).size, (Size{64, 70}));
}

TEST_F(CommandLine, NamesTheValueThatIsWrong) {
  expect_refusal(warp_arguments({"--set", "frame.radius=nan"}), 2,
                 {"--set frame.radius=nan: frame.radius: expected a number from", "not nan"});
  expect_refusal(warp_arguments({"--set", "frame.widht=3"}), 2,
                 {"--set frame.widht=3: frame.widht: unknown key; did you mean width?"});
  expect_refusal(warp_arguments({"--set", "frame"}), 2, {"--set frame: expected key=value"});
}

TEST_F(CommandLine, FindsRigsAndShowsByNameWhateverTheFolder) {
  EXPECT_EQ(call({"check", "--rig", "omnimax"}, {.in_child =
                                                     [] {
                                                       if (chdir("/") != 0) _exit(99);
                                                     }})
                .code,
            0);
  // 1 where the machine is too slow for it.
  EXPECT_NE(call({"check", "demo"}, {.in_child =
                                         [] {
                                           if (chdir("/") != 0) _exit(99);
                                         }})
                .code,
            2);
}

}  // namespace
}  // namespace cupola
