// A rig with a budget, from the command line: what is said, remembered and refused.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/firmware/program.h"

namespace cupola {
namespace {

using testing::HasSubstr;
using testing::Not;

class Budget : public ProgramTest {
 protected:
  Outcome warp(const std::string& budget_ms, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"--set", "filter.budget_ms=" + budget_ms, "--cpu", "scalar"});
    return call(warp_arguments(more), {.environment = {"CUPOLA_CACHE=" + path("cache")}});
  }
};

TEST_F(Budget, OfPlentyGivesTheMostAccurateFilterAndALittleTheCheapest) {
  const Outcome plenty = warp("10000");
  EXPECT_EQ(plenty.code, 0);
  EXPECT_THAT(plenty.err, HasSubstr("rig.toml: budget_ms = 10000: optimal"));
  EXPECT_THAT(plenty.err, HasSubstr("error "));
  const bool precise = plenty.err.find("optimal, precise (") < plenty.err.find("; given up");
  EXPECT_EQ(call({"warp", "--rig", path("rig.toml"), "--view", "front=" + path("front.png"), "--view",
                  "left=" + path("left.png"), "--view", "right=" + path("right.png"), "--view",
                  "top=" + path("top.png"), "--set", "filter.kernel=optimal", "--set",
                  precise ? "filter.table=precise" : "filter.table=fast", "--out", path("named.png")})
                .code,
            0);
  EXPECT_TRUE(read_text(path("frame.png")) == read_text(path("named.png"))) << plenty.err;
  const Outcome little = warp("0.01");
  EXPECT_EQ(little.code, 0);
  EXPECT_THAT(little.err, HasSubstr("budget_ms = 0.01 cannot be held: the cheapest filter is "));
}

TEST_F(Budget, IsMeasuredOnce) {
  EXPECT_THAT(warp("10000").err, HasSubstr("measuring filters"));
  const Outcome second = warp("10000");
  EXPECT_THAT(second.err, Not(HasSubstr("measuring filters")));
  EXPECT_THAT(second.err, HasSubstr("; as measured before\n"));
  EXPECT_THAT(warp("10000", {"--no-cache"}).err, HasSubstr("measuring filters"));
}

TEST_F(Budget, IsForPlayAndRenderAndTableToo) {
  write_text(folder_ / "show.toml", R"(rig = "rig.toml"
[[cue]]
name = "stills"
source = "stills"
file = "{view}.png"
duration_s = 0.1
[[cue]]
name = "again"
source = "stills"
file = "{view}.png"
duration_s = 0.1
)");
  const Circumstances cached{.environment = {"CUPOLA_CACHE=" + path("cache")}};
  const std::string set = "rig.filter.budget_ms=10000";
  const Outcome played = call({"play", path("show.toml"), "--set", set, "--display", "fake", "--fast-forward",
                               "--stats", path("stats.json")},
                              cached);
  EXPECT_EQ(played.code, 0);
  EXPECT_EQ(played.err.find("measuring filters"), played.err.rfind("measuring filters"))
      << "once for both cues";
  EXPECT_THAT(played.err, HasSubstr("optimal"));
  EXPECT_EQ(nlohmann::json::parse(read_text(path("stats.json")))["heap_allocations"], 0);
  const Outcome rendered = call({"render", path("show.toml"), "--set", set, "--out", path("out")}, cached);
  EXPECT_EQ(rendered.code, 0);
  EXPECT_THAT(rendered.err, HasSubstr("; as measured before\n"));
  const Outcome table = call(
      {"table", "--rig", path("rig.toml"), "--set", "filter.budget_ms=10000", "--face-size", "48"}, cached);
  EXPECT_THAT(table.err, HasSubstr("; as measured before\n"));
}

TEST_F(Budget, LeavesOtherMethodsTheirFilterAndSaysSo) {
  const Outcome outcome = warp("8", {"--method", "bilinear"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("budget_ms is for the method ewa; bilinear has the default filter"));
}

TEST_F(Budget, IsRefusedBesideAFilterAndWhereItIsNone) {
  write_rig("both.toml", "[[view]]\nname = \"front\"",
            "[filter]\nbudget_ms = 8.0\nkernel = \"optimal\"\n[[view]]\nname = \"front\"");
  std::vector<std::string> arguments = warp_arguments();
  arguments[2] = path("both.toml");
  ASSERT_EQ(arguments[1], "--rig");
  expect_refusal(arguments, 2, {"both.toml:14: filter.kernel: expected no kernel beside budget_ms"});
  expect_refusal(warp_arguments({"--set", "filter.budget_ms=0"}), 2, {"filter.budget_ms", "expected"});
  expect_refusal(warp_arguments({"--set", "filter.budget_ms=soon"}), 2, {"filter.budget_ms", "expected"});
  expect_refusal(warp_arguments({"--set", "filter.budget=8"}), 2, {"known are alpha, budget_ms"});
}

TEST_F(Budget, IsRefusedWhereTheShowIsLive) {
  expect_refusal({"play", "live", "--set", "rig.filter.budget_ms=8", "--display", "fake", "--seconds", "1"},
                 2, {"filter.budget_ms", "where a cue is live"});
}

}  // namespace
}  // namespace cupola
