// Table files: read as they were built, and refused when anything about them is wrong.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/table_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"
#include "pipeline/warp/table_check.h"
#include "pipeline/warp/table_key.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

const std::vector<std::string> kFour = {"front", "left", "right", "top"};

// A copy of a file that may be damaged; begins on a page as mapped files do.
MappedBytes copy_of(std::span<const std::byte> file, std::size_t count) {
  MappedBytes copy = MappedBytes::zeros(count);
  std::memcpy(copy.writable().data(), file.data(), std::min(count, file.size()));
  return copy;
}

class TableFile : public testing::Test {
 protected:
  std::span<const std::byte> file() const { return table_.memory.bytes(); }

  WorkerPool pool_{2};
  Rig rig_ = test::omnimax_rig({70, 52}, 70, {48, 48}, kFour);
  WarpTable table_ = build_warp_table(rig_, pool_);
};

TEST_F(TableFile, HoldsTheTableThatWasBuilt) {
  const auto read = read_table(file(), rig_, pool_);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->lines.size(), table_.lines.size());
  EXPECT_EQ(read->needed.size(), table_.needed.size());
  EXPECT_EQ(read->needed[1].rows, table_.needed[1].rows);
  EXPECT_EQ(read->taps, table_.taps);
  EXPECT_EQ(read->pixels_in_image, table_.pixels_in_image);
  EXPECT_EQ(read->blocks_of_kind, table_.blocks_of_kind);
  const test::Faces faces = test::make_faces(rig_, test::noise(1));
  ImageBuffer a(PixelFormat::kRgbPlanar8, rig_.frame.size);
  ImageBuffer b(PixelFormat::kRgbPlanar8, rig_.frame.size);
  make_table_warp(table_, best_cpu(), pool_)->warp(faces.images, a.pixels());
  make_table_warp(*read, best_cpu(), pool_)->warp(faces.images, b.pixels());
  EXPECT_TRUE(test::same_pixels(as_const(a.pixels()), as_const(b.pixels())));
}

TEST_F(TableFile, IsTheSameForEveryNumberOfThreads) {
  WorkerPool alone(1);
  const WarpTable again = build_warp_table(rig_, alone);
  ASSERT_EQ(again.memory.bytes().size(), file().size());
  EXPECT_EQ(std::memcmp(again.memory.bytes().data(), file().data(), file().size()), 0);
}

TEST_F(TableFile, IsRefusedWithAnyByteChanged) {
  MappedBytes copy = copy_of(file(), file().size());
  const std::span<std::byte> bytes = copy.writable();
  std::mt19937 random(3);
  for (std::size_t i = 0; i < bytes.size(); i += i < 4096 ? 1 : 1 + random() % 97) {
    const auto change = static_cast<std::byte>(1 + random() % 255);
    bytes[i] ^= change;
    EXPECT_FALSE(read_table(bytes, rig_, pool_)) << i;
    bytes[i] ^= change;
  }
  EXPECT_TRUE(read_table(bytes, rig_, pool_));
}

TEST_F(TableFile, IsRefusedWhenItIsShorterOrLonger) {
  std::mt19937 random(4);
  for (std::size_t count = 1; count < file().size(); count += count < 300 ? 1 : 1 + random() % 997) {
    EXPECT_FALSE(read_table(copy_of(file(), count).bytes(), rig_, pool_)) << count;
  }
  EXPECT_FALSE(read_table({}, rig_, pool_));
  EXPECT_FALSE(read_table(copy_of(file(), file().size() - 1).bytes(), rig_, pool_));
  EXPECT_FALSE(read_table(copy_of(file(), file().size() + 64).bytes(), rig_, pool_));
}

TEST_F(TableFile, IsRefusedForAnotherRig) {
  const auto expect_refused = [&](const auto& change) {
    Rig other = rig_;
    change(other);
    EXPECT_NE(table_key(other), table_key(rig_));
    EXPECT_NE(hash_of(table_key(other)), hash_of(table_key(rig_)));
    EXPECT_FALSE(read_table(file(), other, pool_));
  };
  expect_refused([](Rig& rig) { rig.filter.alpha += 1e-15 * rig.filter.alpha; });
  expect_refused([](Rig& rig) { rig.filter.radius = 1.5; });
  expect_refused([](Rig& rig) { rig.filter.rec = 0.25; });
  expect_refused([](Rig& rig) { rig.filter.table = TableForm::kPrecise; });
  expect_refused([](Rig& rig) { rig.frame.center.x += 1e-9; });
  expect_refused([](Rig& rig) { rig.frame.radius += 1; });
  expect_refused([](Rig& rig) { rig.frame.crop = Crop::kOmnimax; });
  expect_refused([](Rig& rig) { rig.frame.size.width += 1; });
  expect_refused([](Rig& rig) { rig.frame.lens.coefficients[3] += 1e-6; });
  expect_refused([](Rig& rig) { rig.frame.lens = equidistant(180); });
  expect_refused([](Rig& rig) { rig.frame.model = FrameModel::kChromeBall; });
  expect_refused([](Rig& rig) { rig.views[2].size.height = 49; });
  expect_refused([](Rig& rig) { rig.views[2].focal.y = 0.49; });
  expect_refused([](Rig& rig) { rig.views[1].principal.x = 0.51; });
  expect_refused([](Rig& rig) { rig.views[1].forward.y += 1e-12; });
  expect_refused([](Rig& rig) { rig.views[0].coefficients[7] = 1e-3; });
  expect_refused([](Rig& rig) { rig.views[0].shift.z = 1e-9; });
  expect_refused([](Rig& rig) { std::swap(rig.views[1], rig.views[2]); });
  expect_refused([](Rig& rig) { rig.views.pop_back(); });
}

TEST_F(TableFile, IsThatOfARigWithOtherNames) {
  Rig renamed = rig_;
  renamed.file = "elsewhere.toml";
  renamed.frame.lens.name = "mine";
  renamed.views[0].name = "ahead";
  renamed.views[0].position_m = {1.0, 2.0, 3.0};  // without a distance
  EXPECT_EQ(table_key(renamed), table_key(rig_));
  EXPECT_TRUE(read_table(file(), renamed, pool_));
}

// As the fuzzer does it, for every run of the tests: what gets past the checksum is refused or harmless.
TEST_F(TableFile, CanBeExecutedWheneverItIsRead) {
  const test::Faces faces = test::make_faces(rig_, test::noise(1, 65535), PixelFormat::kRgbPlanar16);
  ImageBuffer frame(PixelFormat::kRgbPlanar16, rig_.frame.size);
  std::mt19937 random(5);
  int read = 0;
  const auto weights =
      static_cast<std::size_t>(reinterpret_cast<const std::byte*>(table_.lines.data()) - file().data());
  for (int i = 0; i < 2000; ++i) {
    MappedBytes copy = copy_of(file(), file().size());
    for (auto changes = 1 + random() % 3; changes > 0; --changes) {
      copy.writable()[random() % weights] = static_cast<std::byte>(random());
    }
    correct_checksum(copy.writable(), pool_);
    const auto table = read_table(copy.bytes(), rig_, pool_);
    if (!table) continue;
    ++read;
    make_table_warp(*table, Cpu::kScalar, pool_)->warp(faces.images, frame.pixels());
  }
  EXPECT_GT(read, 20);
}

// Behind a right checksum every part is still looked at.
class TableCheck : public TableFile {
 protected:
  // A table with one value changed.
  template <class Part, class Change>
  void expect_unsound(std::span<const Part> WarpTable::*part, std::size_t at, Change change) {
    std::vector<Part> changed((table_.*part).begin(), (table_.*part).end());
    change(changed[at]);
    const std::span<const Part> whole = table_.*part;
    table_.*part = changed;
    EXPECT_FALSE(is_sound(table_, pool_)) << testing::UnitTest::GetInstance()->current_test_info()->name();
    table_.*part = whole;
    EXPECT_TRUE(is_sound(table_, pool_));
  }
};

TEST_F(TableCheck, RefusesWindowsOutsideTheirView) {
  const std::size_t last = table_.windows.size() - 1;
  expect_unsound(&WarpTable::windows, 3, [](Window& window) { window.x = 41; });
  expect_unsound(&WarpTable::windows, last, [](Window& window) { window.y = 0xffff; });
  expect_unsound(&WarpTable::windows, 0, [](Window& window) { window.view = 4; });
}

TEST_F(TableCheck, RefusesPatchesOutsideTheirWindow) {
  expect_unsound(&WarpTable::windows, 0, [](Window& window) { window.rows = 0; });
  expect_unsound(&WarpTable::windows, 0, [](Window& window) { window.rows = 9; });
  expect_unsound(&WarpTable::windows, 0, [](Window& window) { window.used = 9; });
  expect_unsound(&WarpTable::windows, 1, [](Window& window) { window.start[7] = 0x05; });
  expect_unsound(&WarpTable::windows, 1, [](Window& window) { window.start[15] = 0x40; });
}

TEST_F(TableCheck, RefusesBlocksThatTheKernelsDoNotKnow) {
  expect_unsound(&WarpTable::blocks, 0, [](Block& block) { block.kind = static_cast<BlockKind>(4); });
  expect_unsound(&WarpTable::blocks, 0, [](Block& block) { block.bits = 0; });
  expect_unsound(&WarpTable::blocks, 0, [](Block& block) { block.bits = 14; });
  expect_unsound(&WarpTable::blocks, 1, [](Block& block) { block.at = kBlocksInTile; });
  expect_unsound(&WarpTable::blocks, 1, [&](Block& block) { block.at = table_.blocks[0].at; });
  expect_unsound(&WarpTable::blocks, 1, [](Block& block) { block.covered = 0; });
}

TEST_F(TableCheck, RefusesCountsThatDoNotAddUp) {
  expect_unsound(&WarpTable::blocks, 0, [](Block& block) { ++block.window_count; });
  expect_unsound(&WarpTable::blocks, 0, [](Block& block) { block.window_count = 0xffffffff; });
  expect_unsound(&WarpTable::blocks, 0, [](Block& block) { ++block.line_count; });
  expect_unsound(&WarpTable::tiles, 0, [](Tile& tile) { ++tile.block_count; });
  expect_unsound(&WarpTable::tiles, 0, [](Tile& tile) { ++tile.first_line; });
  expect_unsound(&WarpTable::tiles, 1, [](Tile& tile) { ++tile.first_window; });
  expect_unsound(&WarpTable::tiles, 1, [](Tile& tile) { tile.first_block = 0xffffffff; });
  expect_unsound(&WarpTable::tiles, 1, [](Tile& tile) { ++tile.reach_count; });
  expect_unsound(&WarpTable::tiles, 1, [](Tile& tile) { tile.full ^= 1; });
}

TEST_F(TableCheck, RefusesReachesOutsideTheirView) {
  expect_unsound(&WarpTable::reaches, 0, [](Reach& reach) { reach.x1 = 49; });
  expect_unsound(&WarpTable::reaches, 0, [](Reach& reach) { reach.view = 4; });
  expect_unsound(&WarpTable::reaches, 0, [](Reach& reach) { reach.y0 = reach.y1; });
}

}  // namespace
}  // namespace cupola
