// Laying out, sealing and reading a table's bytes.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/table_file.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "pipeline/frame/checksum.h"
#include "pipeline/warp/symmetry.h"
#include "pipeline/warp/table_check.h"
#include "pipeline/warp/table_key.h"

namespace cupola {
namespace {

constexpr std::array<char, 8> kMagic = {'C', 'u', 'p', 'o', 'l', 'a', 'W', 'T'};
constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr std::size_t kAlignment = alignof(WeightLine);
// Summed apart, side by side, and then the sums.
constexpr std::size_t kChecksumPart = std::size_t{512} << 10;

enum Section : std::size_t { kKey, kTiles, kReaches, kBlocks, kWindows, kLines, kNeeded, kSections };
constexpr std::array<std::size_t, kSections> kElementBytes = {
    sizeof(std::uint64_t), sizeof(Tile),       sizeof(Reach),  sizeof(Block),
    sizeof(Window),        sizeof(WeightLine), sizeof(RowSpan)};

struct Header {
  std::array<char, 8> magic{};
  std::uint32_t byte_order = 0;
  std::uint32_t version = 0;
  std::uint64_t bytes = 0;     // of the file
  std::uint64_t checksum = 0;  // of all that follows it
  std::array<std::uint64_t, kSections> count{};
  std::int64_t pixels_in_image = 0;
  std::int64_t pixels_uncovered = 0;
  std::int64_t taps = 0;
  std::array<std::int64_t, kBlockKinds> blocks_of_kind{};
};
static_assert(sizeof(Header) == 144);
constexpr std::size_t kChecked = offsetof(Header, count);  // where the checksum begins

std::size_t aligned(std::size_t at) {
  return (at + kAlignment - 1) / kAlignment * kAlignment;
}

// Where the sections begin, and last where the file ends. The counts are below 2^40.
std::array<std::size_t, kSections + 1> places(const Header& header) {
  std::array<std::size_t, kSections + 1> at{};
  at[0] = aligned(sizeof(Header));
  for (std::size_t i = 0; i < kSections; ++i) {
    at[i + 1] = aligned(at[i] + static_cast<std::size_t>(header.count[i]) * kElementBytes[i]);
  }
  return at;
}

Header header_of(std::span<const std::byte> file) {
  Header header;
  std::memcpy(&header, file.data(), sizeof header);
  return header;
}

// Element is const to read.
template <class Element, class Byte>
std::span<Element> section(std::span<Byte> file, const Header& header, Section which) {
  return {reinterpret_cast<Element*>(file.data() + places(header)[which]),
          static_cast<std::size_t>(header.count[which])};
}

void point_into(WarpTable& table, std::span<const std::byte> file, const Header& header) {
  table.tiles = section<const Tile>(file, header, kTiles);
  table.reaches = section<const Reach>(file, header, kReaches);
  table.blocks = section<const Block>(file, header, kBlocks);
  table.windows = section<const Window>(file, header, kWindows);
  table.lines = section<const WeightLine>(file, header, kLines);
}

std::uint64_t checksum_of(std::span<const std::byte> file, WorkerPool& pool) {
  const std::span<const std::byte> checked = file.subspan(kChecked);
  std::vector<std::uint64_t> sums((checked.size() + kChecksumPart - 1) / kChecksumPart);
  pool.run(static_cast<int>(sums.size()), [&](int i) {
    const auto part = checked.subspan(static_cast<std::size_t>(i) * kChecksumPart);
    sums[static_cast<std::size_t>(i)] = checksum(part.first(std::min(part.size(), kChecksumPart)));
  });
  return checksum(std::as_bytes(std::span(sums)));
}

// Whether sizes and counts agree with each other and with the head.
bool fits(const Header& header, std::size_t bytes, const WarpTable& head) {
  if (header.magic != kMagic || header.byte_order != kByteOrder || header.version != kTableVersion ||
      header.bytes != bytes) {
    return false;
  }
  for (std::size_t i = 0; i < kSections; ++i) {
    if (header.count[i] > bytes / kElementBytes[i]) return false;
  }
  std::size_t rows = 0;
  for (const NeededRegion& region : head.needed) rows += region.rows.size();
  return places(header)[kSections] == bytes &&
         header.count[kTiles] == static_cast<std::size_t>(head.tile_count()) && header.count[kNeeded] == rows;
}

bool read_needed(std::span<const RowSpan> rows, std::vector<NeededRegion>& needed) {
  for (NeededRegion& region : needed) {
    std::copy_n(rows.begin(), region.rows.size(), region.rows.begin());
    rows = rows.subspan(region.rows.size());
    for (const RowSpan& row : region.rows) {
      if (row.first < 0 || row.last < row.first || row.last > region.size.width) return false;
    }
  }
  return true;
}

}  // namespace

WarpTable table_head(const Rig& rig) {
  return table_head(rig, find_reflections(rig));
}

WarpTable table_head(const Rig& rig, const std::vector<Reflection>& reflections) {
  WarpTable table;
  table.frame = rig.frame.size;
  for (const View& view : rig.views) {
    table.views.push_back({std::max(view.size.width, kWindowSide), std::max(view.size.height, kWindowSide)});
    table.needed.push_back(NeededRegion::none(view.size));
  }
  table.reflections = reflections;
  const Reflection& first = table.reflections.front();
  const int width = first.across ? (table.frame.width + 1) / 2 : table.frame.width;
  const int height = first.down ? (table.frame.height + 1) / 2 : table.frame.height;
  table.tiles_across = (width + kTileWidth - 1) / kTileWidth;
  table.tiles_down = (height + kTileHeight - 1) / kTileHeight;
  if (first.across) table.left = width - table.tiles_across * kTileWidth;
  if (first.down) table.top = height - table.tiles_down * kTileHeight;
  return table;
}

TableParts allocate_parts(WarpTable& table, const Rig& rig, const TableCounts& counts) {
  const TableKey key = table_key(rig);
  Header header;
  header.magic = kMagic;
  header.byte_order = kByteOrder;
  header.version = kTableVersion;
  std::size_t rows = 0;
  for (const NeededRegion& region : table.needed) rows += region.rows.size();
  header.count = {key.size(),
                  static_cast<std::size_t>(table.tile_count()),
                  counts.reaches,
                  counts.blocks,
                  counts.windows,
                  counts.lines,
                  rows};
  header.bytes = places(header)[kSections];
  table.memory = MappedBytes::zeros(static_cast<std::size_t>(header.bytes));
  const std::span<std::byte> file = table.memory.writable();
  std::memcpy(file.data(), &header, sizeof header);
  std::copy(key.begin(), key.end(), section<std::uint64_t>(file, header, kKey).begin());
  point_into(table, file, header);
  return {section<Tile>(file, header, kTiles), section<Reach>(file, header, kReaches),
          section<Block>(file, header, kBlocks), section<Window>(file, header, kWindows),
          section<WeightLine>(file, header, kLines)};
}

void seal(WarpTable& table, WorkerPool& pool) {
  const std::span<std::byte> file = table.memory.writable();
  Header header = header_of(file);
  header.pixels_in_image = table.pixels_in_image;
  header.pixels_uncovered = table.pixels_uncovered;
  header.taps = table.taps;
  header.blocks_of_kind = table.blocks_of_kind;
  auto to = section<RowSpan>(file, header, kNeeded).begin();
  for (const NeededRegion& region : table.needed) to = std::copy(region.rows.begin(), region.rows.end(), to);
  std::memcpy(file.data(), &header, sizeof header);
  correct_checksum(file, pool);
}

void correct_checksum(std::span<std::byte> file, WorkerPool& pool) {
  if (file.size() < sizeof(Header)) return;
  Header header = header_of(file);
  header.bytes = file.size();
  header.checksum = checksum_of(file, pool);
  std::memcpy(file.data(), &header, sizeof header);
}

std::optional<WarpTable> read_table(std::span<const std::byte> file, const Rig& rig, WorkerPool& pool) {
  assert(reinterpret_cast<std::uintptr_t>(file.data()) % kAlignment == 0);
  if (file.size() < sizeof(Header)) return std::nullopt;
  const Header header = header_of(file);
  WarpTable table = table_head(rig);
  if (!fits(header, file.size(), table)) return std::nullopt;
  if (!std::ranges::equal(section<const std::uint64_t>(file, header, kKey), table_key(rig))) {
    return std::nullopt;
  }
  if (checksum_of(file, pool) != header.checksum) return std::nullopt;
  point_into(table, file, header);
  table.pixels_in_image = header.pixels_in_image;
  table.pixels_uncovered = header.pixels_uncovered;
  table.taps = header.taps;
  table.blocks_of_kind = header.blocks_of_kind;
  if (!read_needed(section<const RowSpan>(file, header, kNeeded), table.needed)) return std::nullopt;
  if (!is_sound(table, pool)) return std::nullopt;
  return table;
}

}  // namespace cupola
