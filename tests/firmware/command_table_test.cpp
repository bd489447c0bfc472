// cupola table: the numbers it prints and the pictures it draws.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <regex>
#include <set>

#include "pipeline/frame/still.h"
#include "tests/firmware/program.h"

namespace cupola {
namespace {

using Table = ProgramTest;

TEST_F(Table, PrintsWhatTheTableHoldsAndReads) {
  const Outcome outcome = call({"table", "--rig", path("rig.toml"), "--face-size", "48"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  for (const char* line : {"table +[0-9,]+ bytes", "taps +[0-9,]+, [0-9.]+ a pixel",
                           "needs +[0-9,]+ of left's 48 x 48 texels, [0-9.]+ %", "uncovered +0 pixels",
                           "error +0\\.[0-9]+ steps RMS, [0-9.]+ at most"}) {
    EXPECT_TRUE(std::regex_search(outcome.out, std::regex(line))) << line << "\n" << outcome.out;
  }
}

TEST_F(Table, ComesFromTheCacheTheSecondTime) {
  const std::vector<std::string> arguments = {"table", "--rig", path("rig.toml"), "--face-size", "48"};
  const auto with = [&](std::vector<std::string> more, const std::string& variable) {
    more.insert(more.begin(), arguments.begin(), arguments.end());
    const Outcome outcome = call(more, {.environment = {variable}});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    return outcome.out;
  };
  const std::string cache = "CUPOLA_CACHE=" + path("cache");
  EXPECT_THAT(with({}, cache), testing::HasSubstr("built in"));
  EXPECT_THAT(with({"--out", path("a.table")}, cache), testing::HasSubstr("from the cache in"));
  EXPECT_THAT(with({"--no-cache", "--out", path("b.table")}, cache), testing::HasSubstr("built in"));
  EXPECT_THAT(with({}, "CUPOLA_CACHE=off"), testing::HasSubstr("built in"));
  const auto files = std::filesystem::directory_iterator(path("cache"));
  const std::string kept = read_text(files->path());
  EXPECT_EQ(read_text(path("a.table")), kept);
  EXPECT_EQ(read_text(path("b.table")), kept);
}

TEST_F(Table, IsBuiltWithOneWarningWhereTheCacheCannotBeWritten) {
  const Outcome outcome = call({"table", "--rig", path("rig.toml"), "--face-size", "48"},
                               {.environment = {"CUPOLA_CACHE=/proc/nowhere"}});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, testing::HasSubstr("the table is not kept: /proc/nowhere/"));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
}

TEST_F(Table, DrawsTheUnfoldedCubeDarkWhereNothingIsNeeded) {
  EXPECT_EQ(
      call({"table", "--rig", path("rig.toml"), "--face-size", "48", "--picture", path("cube.png")}).code, 0);
  const ImageBuffer cube = read_still(path("cube.png"));
  ASSERT_EQ(cube.size(), (Size{3 * 48, 2 * 48}));
  const auto sum = [&](int x0, int y0) {
    int total = 0;
    for (int y = y0; y < y0 + 8; ++y) {
      for (int x = x0; x < x0 + 8; ++x)
        total += sample(cube, 0, x, y) + sample(cube, 1, x, y) + sample(cube, 2, x, y);
    }
    return total;
  };
  EXPECT_EQ(sum(0, 0), 0) << "a corner of the cross";
  EXPECT_GT(sum(40, 72), 3 * sum(0, 72)) << "the left face's front half and its back half";
}

TEST_F(Table, DrawsTheFrameInTheViewsColours) {
  EXPECT_EQ(call({"table", "--rig", path("rig.toml"), "--face-size", "48", "--map", path("map.png")}).code,
            0);
  const ImageBuffer map = read_still(path("map.png"));
  ASSERT_EQ(map.size(), (Size{96, 70}));
  const auto colour = [&](int x, int y) {
    return std::array{sample(map, 0, x, y), sample(map, 1, x, y), sample(map, 2, x, y)};
  };
  EXPECT_EQ(colour(0, 0), (std::array{0, 0, 0}));
  const auto front = colour(48, 48);
  const auto left = colour(2, 48);
  const auto right = colour(93, 48);
  const auto top = colour(48, 2);
  EXPECT_EQ((std::set{front, left, right, top, std::array{0, 0, 0}}).size(), 5U);
}

}  // namespace
}  // namespace cupola
