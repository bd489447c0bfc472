// cupola play --resume: killed in the middle, and back where the show would be by then.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/firmware/program.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;

class Resume : public ProgramTest {
 protected:
  Resume() {
    write_text(folder_ / "show.toml", R"(rig = "rig.toml"
[[cue]]
name = "opening"
source = "generated"
world = "demo"
face_size = [48, 48]
duration_s = 0.5
[[cue]]
name = "long"
source = "generated"
world = "demo"
face_size = [48, 48]
duration_s = 1000
)");
  }
  Outcome play(
      const std::function<void(pid_t)>& meanwhile = [](pid_t) {}, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"play", path("show.toml"), "--display", "fake", "--resume", path("position")});
    return call(more, {.meanwhile = meanwhile});
  }
  // Waits until the file says so.
  json kept(const std::function<bool(const json&)>& is) const {
    for (int turn = 0; turn < 2000; ++turn, std::this_thread::sleep_for(10ms)) {
      if (!std::filesystem::exists(path("position"))) continue;
      json position = json::parse(read_text(path("position")));
      if (is(position)) return position;
    }
    ADD_FAILURE() << "the position is not kept";
    return {};
  }
};

TEST_F(Resume, AKilledPlayerComesBackWhereTheShowWouldBe) {
  json before;
  const Outcome killed = play([&](pid_t child) {
    before = kept([](const json& position) { return position["cue"] == 2; });
    kill(child, SIGKILL);
  });
  EXPECT_EQ(killed.code, 128 + SIGKILL);
  std::this_thread::sleep_for(1s);
  const auto began = std::chrono::steady_clock::now();
  std::chrono::steady_clock::duration took{};
  json after;
  const Outcome back = play([&](pid_t child) {
    after = kept([&](const json& position) { return position["booted_ns"] != before["booted_ns"]; });
    took = std::chrono::steady_clock::now() - began;
    kill(child, SIGTERM);
  });
  EXPECT_EQ(back.code, 0) << back.err;
  EXPECT_THAT(back.err, HasSubstr("cupola: resumed from cue long, which began"));
  EXPECT_EQ(after["cue_name"], "long");
  EXPECT_LT(took, 3s * 4) << "3 s are the aim; a loaded machine under a sanitizer gets four times as long";
  const auto seconds = [](const json& now, const char* key) { return now[key].get<double>() / 1e9; };
  // As much of the show passed as time did: to the first flip, which comes a moment after the reckoning.
  const double passed = seconds(after, "booted_ns") - seconds(before, "booted_ns");
  EXPECT_GE(passed, 1.0);
  EXPECT_NEAR(seconds(after, "position_ns") - seconds(before, "position_ns"), passed, 0.5);
  EXPECT_TRUE(std::filesystem::exists(path("position"))) << "ended by a signal: it may go on later";
}

TEST_F(Resume, AFileThatSaysNothingStopsNothing) {
  const std::pair<const char*, const char*> files[] = {
      {"", "expected a position that a player wrote; the show begins at its start"},
      {"{\"cupola_position\": 1, \"show\": 3}", "expected a position that a player wrote"},
      {"\xff\xfe[[[[[[[[[[[[", "expected a position that a player wrote"}};
  for (const auto& [text, words] : files) {
    write_text(folder_ / "position", text);
    const Outcome outcome = play([](pid_t) {}, {"--seconds", "0.1"});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_THAT(outcome.err, HasSubstr(words));
  }
}

TEST_F(Resume, AShowThatWouldBeOverBeginsAnew) {
  write_text(
      folder_ / "position",
      R"({"cupola_position": 1, "show": "show", "cue": 2, "cue_name": "long", "position_ns": 999000000000,
  "held": false, "dark": false, "boot": "", "booted_ns": 0, "wall_ns": 0})");
  const Outcome outcome = play([](pid_t) {}, {"--seconds", "0.1"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("the show would be over; it begins at its start"));
}

TEST_F(Resume, AShowThatEndedLeavesNoPosition) {
  const Outcome outcome = play([](pid_t) {}, {"--set", "cue.1.duration_s=0.2"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(path("position")));
}

TEST_F(Resume, IsForRealTime) {
  expect_refusal({"play", path("show.toml"), "--display", "fake", "--fast-forward", "--resume", path("p")}, 2,
                 {"play: --resume is for a show in real time"});
}

TEST_F(Resume, APlaceThatCannotBeWrittenIsSaidOnce) {
  const Outcome outcome = call({"play", path("show.toml"), "--display", "fake", "--seconds", "1.5",
                                "--resume", path("none/position")});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("cupola: the position is not kept: "));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
}

}  // namespace
}  // namespace cupola
