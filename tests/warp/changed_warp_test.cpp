// Warping only what changed: after any edits the frame is what a full warp makes.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <random>

#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

struct Case {
  Size frame;
  int circle;
  std::vector<std::string> names;
};

class ChangedWarp : public testing::TestWithParam<int> {};

const Case kCases[] = {
    {{300, 219}, 300, {"front", "left", "right", "top"}},            // one mirror
    {{300, 300}, 300, {"front", "left", "right", "top", "bottom"}},  // two
    {{301, 217}, 301, {"front", "left", "right", "top", "bottom"}},  // a middle column
    {{255, 255}, 255, {"front", "left", "right", "top", "bottom"}},  // and a middle row
    {{290, 200}, 250, {"front", "left", "top"}},                     // none
};

void edit(ImageBuffer& face, const TexelBox& box, std::mt19937& random) {
  for (int channel = 0; channel < 3; ++channel) {
    for (int y = box.y0; y < box.y1; ++y) {
      auto* row = face.pixels().samples<std::uint8_t>(channel, y);
      for (int x = box.x0; x < box.x1; ++x) row[x] = static_cast<std::uint8_t>(random());
    }
  }
}

TEST_P(ChangedWarp, IsTheFullWarpAfterRandomEdits) {
  const Case& shape = kCases[GetParam()];
  const Size face{150, 140};
  Rig rig = test::omnimax_rig(shape.frame, shape.circle, face, shape.names);
  rig.frame.center = {shape.frame.width / 2.0, shape.frame.height / 2.0};
  WorkerPool pool(2);
  const WarpTable table = build_warp_table(rig, pool);
  const auto warp = make_table_warp(table, best_cpu(), pool);
  test::Faces faces = test::make_faces(rig, test::noise(7));
  for (const PixelFormat format : {PixelFormat::kRgbPlanar8, PixelFormat::kXrgb8888, PixelFormat::kRgb8}) {
    ImageBuffer kept(format, shape.frame);
    ImageBuffer fresh(format, shape.frame);
    warp->warp(faces.images, kept.pixels());
    std::mt19937 random(5);
    std::int64_t skipped = 0;
    for (int round = 0; round < 25; ++round) {
      std::vector<ChangedCells> changed(shape.names.size(), ChangedCells(face));
      for (unsigned edits = random() % 4; edits > 0; --edits) {
        const std::size_t view = random() % shape.names.size();
        TexelBox box;
        box.x0 = static_cast<int>(random() % 150);
        box.y0 = static_cast<int>(random() % 140);
        box.x1 = std::min(150, box.x0 + 1 + static_cast<int>(random() % 20));
        box.y1 = std::min(140, box.y0 + 1 + static_cast<int>(random() % 20));
        edit(faces.buffers[view], box, random);
        changed[view].add(box.x0, box.y0, box.x1, box.y1);
      }
      const WarpWork work = warp->warp_known(faces.images, {changed, {}}, kept.pixels());
      EXPECT_EQ(work.pieces + work.skipped + work.outside,
                static_cast<std::int64_t>(table.tiles.size() * table.reflections.size()));
      skipped += work.skipped;
      warp->warp(faces.images, fresh.pixels());
      ASSERT_TRUE(test::same_pixels(as_const(kept.pixels()), as_const(fresh.pixels()))) << round;
    }
    EXPECT_GT(skipped, 0);
  }
}

TEST_P(ChangedWarp, DoesNothingWhereNothingChanged) {
  const Case& shape = kCases[GetParam()];
  Rig rig = test::omnimax_rig(shape.frame, shape.circle, {150, 140}, shape.names);
  WorkerPool pool(1);
  const WarpTable table = build_warp_table(rig, pool);
  const auto warp = make_table_warp(table, best_cpu(), pool);
  const test::Faces faces = test::make_faces(rig, test::noise(7));
  ImageBuffer frame(PixelFormat::kXrgb8888, shape.frame);
  const std::vector<ChangedCells> unchanged(shape.names.size(), ChangedCells({150, 140}));
  EXPECT_EQ(warp->warp_known(faces.images, {unchanged, {}}, frame.pixels()).pieces, 0);
  EXPECT_TRUE(test::same_pixels(as_const(frame.pixels()),
                                as_const(ImageBuffer(PixelFormat::kXrgb8888, shape.frame).pixels())));
}

INSTANTIATE_TEST_SUITE_P(Shapes, ChangedWarp, testing::Range(0, 5));

}  // namespace
}  // namespace cupola
