// cupola warp: frames, counts and times.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include <sys/resource.h>

#include "pipeline/frame/still.h"
#include "tests/firmware/program.h"

namespace cupola {
namespace {

using testing::HasSubstr;

class Warp : public ProgramTest {
 protected:
  nlohmann::json stats(std::vector<std::string> more) const {
    more.insert(more.end(), {"--stats", path("stats.json")});
    const Outcome outcome = call(warp_arguments(more));
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return nlohmann::json::parse(read_text(folder_ / "stats.json"));
  }
};

TEST_F(Warp, WritesAFrameOfTheRigsSize) {
  const Outcome outcome = call(warp_arguments());
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(probe_still(path("frame.png")).size, (Size{96, 70}));
}

TEST_F(Warp, DoesSoByEveryMethodAndThreadCount) {
  for (const char* method : {"ewa", "ewa-exact", "ewa-scan", "ewa-scan-integer", "ewa-pyramid", "two-pass",
                             "trilinear", "summed-area", "bilinear", "nearest"}) {
    EXPECT_EQ(call(warp_arguments({"--method", method, "--threads", "1"})).code, 0) << method;
    const std::string one = read_text(path("frame.png"));
    EXPECT_EQ(call(warp_arguments({"--method", method, "--threads", "3"})).code, 0) << method;
    EXPECT_EQ(read_text(path("frame.png")), one) << method;
  }
}

TEST_F(Warp, GivesTheSameFrameOnEveryCpu) {
  EXPECT_EQ(call(warp_arguments({"--cpu", "scalar"})).code, 0);
  const std::string scalar = read_text(path("frame.png"));
  EXPECT_EQ(call(warp_arguments()).code, 0);
  EXPECT_EQ(read_text(path("frame.png")), scalar);
}

TEST_F(Warp, WritesAsManyBitsAsTheFacesHaveOrAsAreAskedFor) {
  EXPECT_EQ(call(warp_arguments()).code, 0);
  EXPECT_EQ(probe_still(path("frame.png")).format, PixelFormat::kRgbPlanar8);
  EXPECT_EQ(call(warp_arguments({"--bits", "16"})).code, 0);
  EXPECT_EQ(probe_still(path("frame.png")).format, PixelFormat::kRgbPlanar16);
  EXPECT_EQ(call(warp_arguments({"--bits", "12"})).code, 2);
}

TEST_F(Warp, FiltersInLinearLightWhereTheRigSaysSo) {
  EXPECT_EQ(call(warp_arguments()).code, 0);
  const std::string encoded = read_text(path("frame.png"));
  EXPECT_EQ(call(warp_arguments({"--set", "filter.light=linear"})).code, 0);
  const std::string linear = read_text(path("frame.png"));
  EXPECT_NE(linear, encoded);
  EXPECT_EQ(call(warp_arguments({"--set", "filter.light=linear", "--cpu", "scalar"})).code, 0);
  EXPECT_EQ(read_text(path("frame.png")), linear);
  const Outcome other = call(warp_arguments({"--set", "filter.light=linear", "--method", "bilinear"}));
  EXPECT_EQ(other.code, 0);
  EXPECT_THAT(other.err, HasSubstr("light = linear is for ewa and ewa-exact"));
  const Outcome budget =
      call(warp_arguments({"--set", "filter.light=linear", "--set", "filter.budget_ms=8.0"}));
  EXPECT_EQ(budget.code, 2);
  EXPECT_THAT(budget.err, HasSubstr("light: expected encoded beside budget_ms"));
}

TEST_F(Warp, TakesAnAtlas) {
  EXPECT_EQ(call(warp_arguments()).code, 0);
  ImageBuffer atlas(PixelFormat::kRgb8, {96, 96});
  int cell = 0;
  for (const char* view : {"front", "left", "right", "top"}) {
    convert(read_still(path(std::string(view) + ".png")).pixels(),
            part_of(atlas.pixels(), 48 * (cell % 2), 48 * (cell / 2), {48, 48}));
    ++cell;
  }
  write_png(path("atlas.png"), as_const(atlas.pixels()));
  const Outcome outcome = call({"warp", "--rig", path("rig.toml"), "--atlas", path("atlas.png"), "--layout",
                                "2x2", "--faces", "front,left,right,top", "--out", path("from_atlas.png")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(read_text(path("from_atlas.png")), read_text(path("frame.png")));
}

TEST_F(Warp, KeepsSixteenBits) {
  for (const char* view : {"front", "left", "right", "top"}) {
    const ImageBuffer picture = noise_picture(PixelFormat::kRgb16, {48, 48});
    write_png(path(std::string(view) + ".png"), picture.pixels());
  }
  EXPECT_EQ(call(warp_arguments({"--method", "ewa-exact"})).code, 0);
  EXPECT_EQ(probe_still(path("frame.png")).format, PixelFormat::kRgbPlanar16);
}

TEST_F(Warp, CountsWhatItDid) {
  const nlohmann::json counts = stats({"--repeat", "7", "--threads", "2", "--cpu", "scalar"});
  EXPECT_EQ(counts["method"], "ewa");
  EXPECT_EQ(counts["cpu"], "scalar");
  EXPECT_EQ(counts["threads"], 2);
  EXPECT_EQ(counts["warps"], 7);
  EXPECT_GT(counts["table_bytes"], 0);
  EXPECT_GT(counts["pixels_in_image"], 96 * 70 / 2);
  EXPECT_EQ(counts["pixels_uncovered"], 0);
  EXPECT_LE(counts["warp_ms_min"], counts["warp_ms_median"]);
  EXPECT_LE(counts["warp_ms_median"], counts["warp_ms_max"]);
  for (const char* view : {"front", "left", "right", "top"}) {
    EXPECT_GT(counts["needed_texels"][view], 0) << view;
    EXPECT_LE(counts["needed_texels"][view], 48 * 48) << view;
  }
  EXPECT_LT(counts["needed_texels"]["left"], 48 * 48 * 2 / 3);
}

TEST_F(Warp, DoesTheWholeWorkOnceForEveryRepeat) {
  // Processor time: on a busy machine the wall's is anything.
  const auto used = [] {
    rusage children{};
    getrusage(RUSAGE_CHILDREN, &children);
    const timeval& time = children.ru_utime;
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  const auto time_of = [&](const char* repeat) {
    const double began = used();
    EXPECT_EQ(call(warp_arguments({"--method", "ewa-exact", "--threads", "1", "--repeat", repeat})).code, 0);
    return used() - began;
  };
  const double once = time_of("1");
  const double some = time_of("40");
  const double many = time_of("160");
  // Four times the work, less the start.
  EXPECT_GT(many - once, 2.0 * (some - once));
  EXPECT_LT(many - once, 8.0 * (some - once));
}

TEST_F(Warp, TellsHowManyPixelsNoViewCovers) {
  write_rig("rig.toml", "[[view]]\nname = \"top\"\n", "");
  std::vector<std::string> arguments = warp_arguments({"--stats", path("stats.json")});
  arguments.erase(std::find(arguments.begin(), arguments.end(), "top=" + path("top.png")) - 1,
                  std::find(arguments.begin(), arguments.end(), "top=" + path("top.png")) + 1);
  const Outcome outcome = call(arguments);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::int64_t uncovered = nlohmann::json::parse(read_text(path("stats.json")))["pixels_uncovered"];
  EXPECT_GT(uncovered, 999);
  const std::string number =
      std::to_string(uncovered / 1000) + "," + std::to_string(1000 + uncovered % 1000).substr(1);
  EXPECT_EQ(outcome.out, number + " pixels are covered by no view and stay black\n");
}

}  // namespace
}  // namespace cupola
