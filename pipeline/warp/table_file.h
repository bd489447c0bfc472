// The bytes of a warp table, in memory and in a file: a header, then one section after the other, each from a
// multiple of 64 bytes on. What follows from the rig is not among them, but the rig's key is.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {

// Raised whenever the format changes, or the builder's bytes for any rig do (tests/golden).
inline constexpr std::uint32_t kTableVersion = 3;

struct TableCounts {
  std::size_t reaches = 0;
  std::size_t blocks = 0;
  std::size_t windows = 0;
  std::size_t lines = 0;
};

// Where the builder puts a table's parts.
struct TableParts {
  std::span<Tile> tiles;
  std::span<Reach> reaches;
  std::span<Block> blocks;
  std::span<Window> windows;
  std::span<WeightLine> lines;
};

// What follows from the rig: the frame, the views, the reflections and the grid of tiles, which ends at the
// axes of symmetry. Needs nothing of the views yet.
WarpTable table_head(const Rig& rig);
// The same with fewer reflections than the rig has.
WarpTable table_head(const Rig& rig, const std::vector<Reflection>& reflections);

// Gives a table that has its head room for its parts, all zero.
TableParts allocate_parts(WarpTable& table, const Rig& rig, const TableCounts& counts);

// Once parts, counts and needed regions are in place: the table's memory is then what a file of it holds.
void seal(WarpTable& table, WorkerPool& pool);

// Makes the length and the checksum that `file` has in its header right; does nothing to a file without one.
void correct_checksum(std::span<std::byte> file, WorkerPool& pool);

// The table in `file`, which it borrows; nothing unless that is the whole and undamaged table of this rig, of
// this version, written by a machine of this byte order. `file` begins on a 64-byte boundary. Whatever the
// bytes are, executing the table stays within it and the faces.
std::optional<WarpTable> read_table(std::span<const std::byte> file, const Rig& rig, WorkerPool& pool);

}  // namespace cupola
