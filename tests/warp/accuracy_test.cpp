// The bounds of the fixed-point warp against the unrounded reference, at the paper's production sizes.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <numeric>

#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

WorkerPool& pool() {
  static WorkerPool shared(0);
  return shared;
}

struct Content {
  const char* name;
  test::Faces (*make)(const Rig&);
};

const Content kContents[] = {
    {"noise", [](const Rig& rig) { return test::make_faces(rig, test::noise(1)); }},
    // Figure 6 of the paper shows squares of about a 16th of a face.
    {"checkerboard",
     [](const Rig& rig) { return test::make_faces(rig, test::checkerboard(rig.views[0].size.width / 16)); }},
    {"photograph", [](const Rig& rig) { return test::make_faces(rig, test::photograph(), 1); }},
};

struct Case {
  const char* name;
  Size face;
  TableForm form;
  double rms, max;
};

class ProductionFrame : public testing::TestWithParam<Case> {};

TEST_P(ProductionFrame, StaysWithinItsBoundOfTheReference) {
  const Case& bound = GetParam();
  Rig rig = test::paper_rig(bound.face);
  rig.filter.table = bound.form;
  const WarpTable table = build_warp_table(rig, pool());
  EXPECT_EQ(table.pixels_uncovered, 0);
  const auto warp = make_table_warp(table, best_cpu(), pool());
  ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
  for (const Content& content : kContents) {
    const test::Faces faces = content.make(rig);
    warp->warp(faces.images, frame.pixels());
    const test::Difference d =
        test::difference(rig, as_const(frame.pixels()), ewa_exact_frame(rig, faces.images, pool()));
    RecordProperty(std::string(content.name) + "_rms", std::to_string(d.rms));
    std::printf("%s %s: rms %.3f, max %.2f LSB\n", bound.name, content.name, d.rms, d.max);
    EXPECT_LE(d.rms, bound.rms) << content.name;
    EXPECT_LE(d.max, bound.max) << content.name << " at " << d.x << ' ' << d.y;
    EXPECT_GT(d.samples, 7'000'000);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Paper, ProductionFrame,
    testing::Values(Case{"fast_1024x1024", {1024, 1024}, TableForm::kFast, 0.42, 2.0},
                    Case{"fast_1024x960", {1024, 960}, TableForm::kFast, 0.42, 2.0},
                    Case{"precise_1024x1024", {1024, 1024}, TableForm::kPrecise, 0.30, 0.6}),
    [](const auto& instance) { return instance.param.name; });

TEST(FixedPoint, EvenColourComesOutUnchangedForAllValuesAndChannels) {
  // Every texel of channel c is (value + 85 c) mod 256, so 256 frames show all values in all channels.
  for (const TableForm form : {TableForm::kFast, TableForm::kPrecise}) {
    Rig rig = test::omnimax_rig({246, 180}, 246, {128, 120}, {"front", "left", "right", "top"});
    rig.filter.table = form;
    const WarpTable table = build_warp_table(rig, pool());
    ASSERT_EQ(table.pixels_uncovered, 0);
    const auto warp = make_table_warp(table, best_cpu(), pool());
    ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
    for (unsigned value = 0; value < 256; ++value) {
      const auto colour = [&](int channel) { return (value + 85U * static_cast<unsigned>(channel)) % 256U; };
      const test::Faces faces =
          test::make_faces(rig, [&](int, int channel, int, int) { return colour(channel); });
      warp->warp(faces.images, frame.pixels());
      for (int channel = 0; channel < 3; ++channel) {
        for (int y = 0; y < rig.frame.size.height; ++y) {
          for (int x = 0; x < rig.frame.size.width; ++x) {
            DirectionAndSlope looking;
            const bool inside = ray(rig.frame, {x + 0.5, y + 0.5}, looking);
            ASSERT_EQ(frame.pixels().samples<std::uint8_t>(channel, y)[x], inside ? colour(channel) : 0U);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace cupola
