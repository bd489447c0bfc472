// Packed tables: the same tables, a fraction of the bytes, and nothing from damaged files.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/table_packing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"
#include "pipeline/warp/table_cache.h"
#include "tests/frame/picture_files.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

constexpr std::size_t kPlenty = std::size_t{1} << 30;

std::vector<std::byte> bytes_of_length(std::size_t length) {
  std::mt19937 dice(1);
  std::vector<std::byte> bytes(length);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(dice() % 5);
  return bytes;
}

bool unpacks_to(std::span<const std::byte> packed, std::span<const std::byte> bytes, WorkerPool& pool) {
  const auto unpacked = unpack_table(packed, bytes.size(), pool);
  return unpacked && std::ranges::equal(unpacked->bytes(), bytes);
}

TEST(TablePacking, GivesBackEveryByteWhateverTheLength) {
  WorkerPool one(1);
  WorkerPool three(3);
  for (const std::size_t length :
       {std::size_t{1}, std::size_t{1000}, kPackedPart - 1, kPackedPart, kPackedPart + 1, 5 * kPackedPart}) {
    const std::vector<std::byte> bytes = bytes_of_length(length);
    const std::vector<std::byte> packed = pack_table(bytes, three);
    EXPECT_LT(packed.size(), length / 2 + 20);
    EXPECT_TRUE(pack_table(bytes, one) == packed) << length;
    EXPECT_TRUE(unpacks_to(packed, bytes, one)) << length;
    EXPECT_TRUE(unpacks_to(packed, bytes, three)) << length;
    EXPECT_FALSE(unpack_table(packed, length - 1, one)) << "more than allowed";
  }
}

TEST(TablePacking, TakesNoDamagedFile) {
  WorkerPool pool(2);
  const std::vector<std::byte> bytes = bytes_of_length(2 * kPackedPart + 1000);
  const std::vector<std::byte> packed = pack_table(bytes, pool);
  EXPECT_FALSE(unpack_table({}, kPlenty, pool));
  EXPECT_FALSE(unpack_table(bytes, kPlenty, pool)) << "not packed at all";
  std::mt19937 dice(2);
  for (int i = 0; i < 100; ++i) {
    std::vector<std::byte> damaged = packed;
    damaged[dice() % damaged.size()] ^= static_cast<std::byte>(1U << dice() % 8);
    const auto unpacked = unpack_table(damaged, kPlenty, pool);
    EXPECT_TRUE(!unpacked || std::ranges::equal(unpacked->bytes(), bytes));
    damaged = packed;
    damaged.resize(dice() % (packed.size() - 1) + 1);  // at a frame's end it is a shorter file
    const auto cut = unpack_table(damaged, kPlenty, pool);
    EXPECT_TRUE(!cut || cut->bytes().size() % kPackedPart == 0);
  }
}

// Two frames that both claim the most there may be, in a few bytes.
TEST(TablePacking, TakesNoMoreMemoryThanItIsGiven) {
  WorkerPool pool(1);
  const std::vector<std::byte> zeros(64 * kPackedPart);
  const std::vector<std::byte> packed = pack_table(zeros, pool);
  EXPECT_LT(packed.size(), 64U * 1024);
  EXPECT_FALSE(unpack_table(packed, 63 * kPackedPart, pool));
  EXPECT_TRUE(unpack_table(packed, 64 * kPackedPart, pool));
}

Rig paper_rig(TableForm form) {
  Rig rig = test::omnimax_rig({490, 360}, 490, {256, 256}, {"front", "left", "right", "top"});
  rig.filter.table = form;
  return rig;
}

TEST(CompactTable, MakesTheFastTablesFrame) {
  WorkerPool pool(2);
  std::array<ImageBuffer, 2> frames;
  for (const TableForm form : {TableForm::kFast, TableForm::kCompact}) {
    const Rig rig = paper_rig(form);
    const test::Faces faces = test::make_faces(rig, test::noise(1, 255), PixelFormat::kRgbPlanar8);
    ImageBuffer& frame = frames[form == TableForm::kFast ? 0 : 1];
    frame = ImageBuffer(PixelFormat::kRgbPlanar8, rig.frame.size);
    make_table_warp(build_warp_table(rig, pool), Cpu::kScalar, pool)->warp(faces.images, frame.pixels());
  }
  EXPECT_TRUE(test::same_pixels(frames[0].pixels(), frames[1].pixels()));
}

TEST(CompactTable, IsKeptInAtMostSixBytesAPixel) {
  WorkerPool pool(2);
  const WarpTable table = build_warp_table(paper_rig(TableForm::kCompact), pool);
  const auto packed = static_cast<double>(pack_table(table.memory.bytes(), pool).size());
  EXPECT_LE(packed, 6.0 * static_cast<double>(table.pixels_in_image));
}

TEST(CompactTable, ComesFromTheCacheAndIsReplacedWhereItIsDamaged) {
  WorkerPool pool(2);
  const TemporaryFolder folder;
  const Rig rig = paper_rig(TableForm::kCompact);
  const WarpTable built = build_warp_table(rig, pool);
  const auto finds = [&] {
    TableCache cache(folder / "c");
    const WarpTable table = cache.table(rig, pool);
    EXPECT_EQ(cache.trouble(), "");
    EXPECT_TRUE(std::ranges::equal(table.memory.bytes(), built.memory.bytes()));
    return cache.found() == 1;
  };
  EXPECT_FALSE(finds());
  EXPECT_TRUE(finds());
  const std::filesystem::path file = std::filesystem::directory_iterator(folder / "c")->path();
  EXPECT_EQ(file.extension(), ".zst");
  EXPECT_LT(std::filesystem::file_size(file), built.memory.bytes().size() * 2 / 3);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  EXPECT_FALSE(finds());
  EXPECT_TRUE(finds());
}

}  // namespace
}  // namespace cupola
