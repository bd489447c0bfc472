// What warp, render and play leave out of a sequence: counted, and never seen in the frames.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "pipeline/frame/still.h"
#include "tests/firmware/program.h"

namespace cupola {
namespace {

constexpr int kFrames = 6;
const std::vector<std::string> kViews = {"front", "left", "right", "top"};
constexpr Size kFace{128, 128};

// Frames: noise; a few texels of it changed; the same again; black; one texel of it grey; noise.
class SkippingProgram : public ProgramTest {
 protected:
  SkippingProgram() {
    write_rig("large.toml", "width = 96\nheight = 70\ncenter = [48.0, 48.0]\nradius = 48.0",
              "width = 301\nheight = 219\ncenter = [150.5, 150.5]\nradius = 150.5");
    write_text(folder_ / "show.toml", R"(rig = "large.toml"
[[cue]]
name = "sequence"
source = "sequence"
file = "{view}_%06d.png"
)");
    for (std::size_t view = 0; view < kViews.size(); ++view) {
      ImageBuffer face = noise_picture(PixelFormat::kRgbPlanar8, kFace, static_cast<std::uint32_t>(view));
      const bool front = view == 0;
      write(view, 1, face);
      for (int y = 40; front && y < 50; ++y) std::memset(face.pixels().planes[1].row(y) + 60, 77, 10);
      write(view, 2, face);
      write(view, 3, face);
      face = ImageBuffer(PixelFormat::kRgbPlanar8, kFace);
      write(view, 4, face);
      if (front) face.pixels().planes[2].row(70)[70] = std::byte{128};
      write(view, 5, face);
      write(view, 6, noise_picture(PixelFormat::kRgbPlanar8, kFace, 9 + static_cast<std::uint32_t>(view)));
    }
    // The frames without any skipping, and what there is to skip.
    for (int number = 1; number <= kFrames; ++number) {
      std::vector<std::string> arguments = {
          "warp", "--rig", path("large.toml"), "--out", path(whole(number)), "--stats", path("w.json")};
      for (const std::string& view : kViews) {
        arguments.insert(arguments.end(), {"--view", view + "=" + path(face_name(view, number))});
      }
      const Outcome outcome = call(arguments);
      EXPECT_EQ(outcome.code, 0) << outcome.err;
    }
    const nlohmann::json stats = nlohmann::json::parse(read_text(folder_ / "w.json"));
    tiles_ = stats["tiles_warped"];
    outside_ = stats["skipped"]["tiles_outside"];
    unneeded_ = stats["skipped"]["face_texels_unneeded"];
    EXPECT_EQ(stats["tiles_skipped"], outside_);
    EXPECT_EQ(stats["skipped"]["tiles_unchanged"], 0) << "warp skips nothing that it could do again";
    EXPECT_EQ(stats["skipped"]["tiles_even"], 0);
    EXPECT_GT(tiles_, 30);
    EXPECT_GT(outside_, 0);
    EXPECT_GT(unneeded_, 0);
  }

  static std::string whole(int number) { return "whole_" + std::to_string(number) + ".png"; }
  static std::string face_name(const std::string& view, int number) {
    return view + "_00000" + std::to_string(number) + ".png";
  }
  void write(std::size_t view, int number, const ImageBuffer& face) const {
    write_png(folder_ / face_name(kViews[view], number), face.pixels());
  }
  void expect_whole_frames(const std::string& folder) const {
    for (int number = 1; number <= kFrames; ++number) {
      const std::string name = folder + "/show_00000" + std::to_string(number) + ".png";
      EXPECT_TRUE(read_text(path(name)) == read_text(path(whole(number)))) << name;
    }
  }
  nlohmann::json stats() const { return nlohmann::json::parse(read_text(folder_ / "stats.json")); }

  std::int64_t tiles_ = 0;     // that show something
  std::int64_t outside_ = 0;   // that do not
  std::int64_t unneeded_ = 0;  // texels of one frame's faces
};

TEST_F(SkippingProgram, RendersTheFramesThatAFullWarpMakes) {
  for (const char* threads : {"1", "2", "3"}) {
    const std::string out = std::string("out") + threads;
    const Outcome outcome = call({"render", path("show.toml"), "--out", path(out), "--threads", threads,
                                  "--stats", path("stats.json")});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    expect_whole_frames(out);
    const nlohmann::json counts = stats();
    EXPECT_EQ(counts["frames"], kFrames);
    EXPECT_EQ(counts["tiles_warped"].get<int>() + counts["tiles_skipped"].get<int>(),
              kFrames * (tiles_ + outside_));
    EXPECT_EQ(counts["skipped"]["tiles_outside"], kFrames * outside_);
    EXPECT_EQ(counts["skipped"]["face_texels_unneeded"], (kFrames - 1) * unneeded_)
        << "the third frame's faces are the second's";
    EXPECT_EQ(counts["skipped"]["pictures_repeated"], 3 + 4 + 3)
        << "what is not front in the second, all of the third, what is not front in the fifth";
  }
}

TEST_F(SkippingProgram, CountsEveryTileByWhatBecameOfIt) {
  const Outcome outcome = call(
      {"render", path("show.toml"), "--out", path("out"), "--threads", "1", "--stats", path("stats.json")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const nlohmann::json counts = stats();
  EXPECT_EQ(counts["skipped"]["tiles_even"], tiles_) << "the black frame";
  const std::int64_t moved = counts["tiles_warped"].get<std::int64_t>() - 2 * tiles_;  // but for the noise
  EXPECT_GE(moved, 2);
  EXPECT_LT(moved, tiles_ / 2);
  EXPECT_EQ(counts["skipped"]["tiles_unchanged"], 3 * tiles_ - moved);
}

TEST_F(SkippingProgram, PlaysTheFramesThatAFullWarpMakes) {
  const Outcome outcome = call(
      {"play", path("show.toml"), "--display", "file", "--out", path("out"), "--stats", path("stats.json")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_whole_frames("out");
  const nlohmann::json counts = stats();
  EXPECT_EQ(counts["frames_unchanged"], 1);
  EXPECT_EQ(counts["skipped"]["tiles_even"], tiles_);
  EXPECT_EQ(counts["skipped"]["tiles_outside"], (kFrames - 1) * outside_);
  EXPECT_EQ(
      counts["skipped"]["tiles_unchanged"].get<std::int64_t>() + counts["tiles_warped"].get<std::int64_t>(),
      (kFrames - 2) * tiles_);
  EXPECT_GT(counts["skipped"]["tiles_unchanged"], tiles_);
  EXPECT_EQ(counts["skipped"]["face_texels_unneeded"], (kFrames - 1) * unneeded_);
}

}  // namespace
}  // namespace cupola
