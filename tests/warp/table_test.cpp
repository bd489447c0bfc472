// The warp table: its promises to the kernels, exact sums, needed regions, and that building it is a pure
// function.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <random>

#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"
#include "tests/warp/block_check.h"
#include "tests/warp/faces.h"
#include "tests/warp/random_table.h"

namespace cupola {
namespace {

const std::vector<std::string> kAllNames = {"front", "left", "right", "top", "bottom", "back"};

bool same_bytes(const WarpTable& a, const WarpTable& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0;
  };
  return same(a.tiles, b.tiles) && same(a.blocks, b.blocks) && same(a.windows, b.windows) &&
         same(a.lines, b.lines);
}

TEST(RandomTable, KeepsThePromisesThatKernelsRelyOn) {
  test::Random random(8);
  for (const BlockKind kind :
       {BlockKind::kNarrow8, BlockKind::kSigned8, BlockKind::kNarrow16, BlockKind::kWide16}) {
    for (int i = 0; i < 20; ++i) {
      test::expect_sound(test::random_table(random, std::array{kind}, {{8, 8}, {40, 17}}, 3).table);
    }
  }
}

TEST(WarpTableOf, EveryGeometryKeepsItsPromises) {
  WorkerPool pool(2);
  std::mt19937 random(7);
  for (int i = 0; i < 40; ++i) {
    const auto side = [&](int most) { return std::uniform_int_distribution<>(1, most)(random); };
    Rig rig = test::omnimax_rig({side(200), side(200)}, side(300), {side(300), side(300)}, kAllNames);
    if (i % 3 == 2) {
      const std::array<FilterSettings, 3> lobed = {robidoux_filter(), jinc_filter(), optimal_filter()};
      rig.filter = lobed[static_cast<std::size_t>(i) / 3 % 3];
    } else {
      rig.filter.radius = std::uniform_real_distribution<>(0.5, 2.5)(random);
      rig.filter.rec = i % 3 == 0 ? 1.0 : 0.0;
    }
    rig.filter.table = i % 2 == 0 ? TableForm::kFast : TableForm::kPrecise;
    SCOPED_TRACE(i);
    test::expect_sound(build_warp_table(rig, pool));
  }
}

TEST(WarpTableOf, AllThreeKindsOccurAndArePureFunctionsOfTheRig) {
  const Rig rig = [] {
    Rig minified = test::omnimax_rig({100, 90}, 180, {300, 300}, kAllNames);
    minified.filter.radius = 1.0;
    return minified;
  }();
  WorkerPool one(1);
  WorkerPool three(3);
  const WarpTable table = build_warp_table(rig, one);
  EXPECT_TRUE(same_bytes(table, build_warp_table(rig, three)));
  EXPECT_TRUE(same_bytes(table, build_warp_table(rig, one)));
  Rig wide = rig;
  for (View& view : wide.views) view.size = {900, 900};
  EXPECT_GT(build_warp_table(wide, one).blocks_of_kind[static_cast<int>(BlockKind::kWide16)], 0);
  EXPECT_LT(table.blocks.size(), table.tiles.size() * kBlocksInTile);  // the corners of the frame are empty
  EXPECT_GT(build_warp_table(test::paper_rig({256, 256}), one)
                .blocks_of_kind[static_cast<int>(BlockKind::kNarrow8)],
            0);
}

TEST(WarpTableOf, CountsPixelsInTheImageAndUncoveredOnes) {
  WorkerPool pool(2);
  const Rig rig = test::omnimax_rig({101, 99}, 98, {64, 64}, {"front", "top"});
  const WarpTable table = build_warp_table(rig, pool);
  std::int64_t in_image = 0;
  std::int64_t uncovered = 0;
  for (int y = 0; y < 99; ++y) {
    for (int x = 0; x < 101; ++x) {
      DirectionAndSlope looking;
      if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking)) continue;
      ++in_image;
      uncovered += owner(rig.views, looking.direction) < 0 ? 1 : 0;
    }
  }
  EXPECT_EQ(table.pixels_in_image, in_image);
  EXPECT_EQ(table.pixels_uncovered, uncovered);
  EXPECT_GT(uncovered, 0);
}

TEST(WarpTableOf, NothingOutsideTheNeededRegionChangesThePicture) {
  WorkerPool pool(2);
  const Rig rig = test::paper_rig({128, 120});
  const WarpTable table = build_warp_table(rig, pool);
  const auto inside = [&](int view, int x, int y) {
    const RowSpan& row = table.needed[view].rows[y];
    return x >= row.first && x < row.last;
  };
  const auto picture = test::noise(5);
  const test::Faces clean = test::make_faces(rig, picture);
  const test::Faces poisoned = test::make_faces(rig, [&](int view, int channel, int x, int y) {
    return inside(view, x, y) ? clean.images[view].samples<std::uint8_t>(channel, y)[x] : 255U - x % 7;
  });
  ImageBuffer a(PixelFormat::kRgbPlanar8, rig.frame.size);
  ImageBuffer b(PixelFormat::kRgbPlanar8, rig.frame.size);
  for (const Cpu cpu : {Cpu::kScalar, best_cpu()}) {
    make_table_warp(table, cpu, pool)->warp(clean.images, a.pixels());
    make_table_warp(table, cpu, pool)->warp(poisoned.images, b.pixels());
    EXPECT_TRUE(test::same_pixels(as_const(a.pixels()), as_const(b.pixels())));
  }
}

TEST(WarpTableOf, TheSidesBeyondTheLimbAreNotNeeded) {
  // Figure 3 of the paper: the left half of the left panel, the right half of the right, the top half of the
  // top.
  WorkerPool pool(2);
  const Rig rig = test::paper_rig({512, 512});
  const WarpTable table = build_warp_table(rig, pool);
  constexpr int kFootprint = 4;
  for (int y = 0; y < 512; ++y) {
    const RowSpan& left = table.needed[1].rows[y];
    const RowSpan& right = table.needed[2].rows[y];
    if (!left.empty()) {
      EXPECT_GE(left.first, 256 - kFootprint);
    }
    if (!right.empty()) {
      EXPECT_LE(right.last, 256 + kFootprint);
    }
    if (y < 256 - kFootprint) {
      EXPECT_TRUE(table.needed[3].rows[y].empty());
    }
  }
  EXPECT_LT(table.needed[1].texels(), 512 * 512 * 52 / 100);
  EXPECT_GT(table.needed[0].texels(), 512 * 512 * 90 / 100);
}

TEST(WarpTableOf, DomemasterOf4096From2048FacesStaysWithinTwoGigabytes) {
  WorkerPool pool(0);
  Rig rig = test::omnimax_rig({4096, 4096}, 4096, {2048, 2048}, {"front", "left", "right", "top", "bottom"});
  rig.frame.lens = equidistant(180);
  const WarpTable table = build_warp_table(rig, pool);
  EXPECT_EQ(table.pixels_uncovered, 0);
  EXPECT_LT(table.bytes(), 400U << 20U);
}

}  // namespace
}  // namespace cupola
