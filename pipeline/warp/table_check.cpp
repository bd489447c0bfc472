// Tile by tile, after it is sure that each tile's parts are its own.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/table_check.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <bitset>
#include <cstring>

namespace cupola {
namespace {

struct BitRange {
  std::uint32_t least, most;
};

BitRange bits_of(BlockKind kind) {
  switch (kind) {
    case BlockKind::kNarrow8:
      return {kLeastBits8, kMostBits8};
    case BlockKind::kSigned8:
      return {kLeastSignedBits8, kMostSignedBits8};
    default:
      return {kSignedBits16, kMostBits16};
  }
}

// The parts of one tile.
struct TileSpan {
  const Tile& tile;
  std::span<const Reach> reaches;
  std::span<const Block> blocks;
  std::span<const Window> windows;
  std::size_t lines;
};

class TileCheck {
 public:
  explicit TileCheck(std::span<const Size> views) : views_(views) {}

  bool passes(const TileSpan& span) const {
    std::bitset<kBlocksInTile> taken;
    std::size_t window = 0;
    std::size_t line = 0;
    int covered = 0;
    for (const Block& block : span.blocks) {
      if (static_cast<std::size_t>(block.kind) >= kBlockKinds) return false;
      const BitRange bits = bits_of(block.kind);
      if (block.bits < bits.least || block.bits > bits.most || block.covered == 0 ||
          block.at >= kBlocksInTile || taken[block.at] || block.window_count == 0 ||
          block.window_count > span.windows.size() - window) {
        return false;
      }
      taken[block.at] = true;
      covered += std::popcount(block.covered);
      std::size_t lines = 0;
      for (const Window& at : span.windows.subspan(window, block.window_count)) {
        if (!fits(at) || !(block.kind == BlockKind::kWide16 ? wide(at) : narrow(at))) return false;
        lines += block.kind == BlockKind::kWide16     ? 2U
                 : block.kind == BlockKind::kNarrow16 ? 2U * at.rows
                                                      : at.rows;
      }
      if (lines != block.line_count) return false;
      window += block.window_count;
      line += lines;
    }
    const bool full = covered == kTileWidth * kTileHeight;
    return window == span.windows.size() && line == span.lines && span.tile.full == (full ? 1 : 0) &&
           std::all_of(span.reaches.begin(), span.reaches.end(), [&](const Reach& r) { return fits(r); });
  }

 private:
  bool fits(const Window& window) const {
    return window.view < views_.size() && window.x + kWindowSide <= views_[window.view].width &&
           window.y + kWindowSide <= views_[window.view].height && window.used <= kWindowSide;
  }
  bool fits(const Reach& reach) const {
    return reach.view < views_.size() && reach.x0 < reach.x1 && reach.x1 <= views_[reach.view].width &&
           reach.y0 < reach.y1 && reach.y1 <= views_[reach.view].height;
  }
  static bool wide(const Window& window) {
    return window.used == kWindowSide && window.start[0] < kPixelsInBlock;
  }
  // Eight starts at a time, since there are millions: a sum that reaches a byte's top bit is too large.
  static bool narrow(const Window& window) {
    if (window.rows < 1 || window.rows > window.used || window.spread >= kWindowSide) return false;
    constexpr std::uint64_t kEach = 0x0101010101010101;
    const auto rows_left = static_cast<std::uint64_t>(window.used - window.rows);    // 0..7
    const std::uint64_t past_rows = kEach * (0x80 - kWindowSide * (rows_left + 1));  // starts below 8 .. 64
    constexpr std::uint64_t kPastColumns =
        kEach * (0x80 - (kWindowSide - kPatchWidth + 1));  // columns up to 4
    std::array<std::uint64_t, 2> starts;
    static_assert(sizeof starts == sizeof window.start);
    std::memcpy(starts.data(), window.start.data(), sizeof starts);
    std::uint64_t past = 0;
    for (const std::uint64_t eight : starts) {
      past |= eight;  // 128 and more; without those no byte's sum carries into the next
      past |= (eight & ~(kEach * 0x80)) + past_rows;
      past |= (eight & (kEach * (kWindowSide - 1))) + kPastColumns;
    }
    return (past & (kEach * 0x80)) == 0;
  }

  std::span<const Size> views_;
};

// Where a tile's parts begin.
struct Place {
  std::uint64_t reach, block, window, line;
};

bool rises(const Place& from, const Place& to) {
  return from.reach <= to.reach && from.block <= to.block && from.window <= to.window && from.line <= to.line;
}

}  // namespace

bool is_sound(const WarpTable& table, WorkerPool& pool) {
  const Place end{table.reaches.size(), table.blocks.size(), table.windows.size(), table.lines.size()};
  const auto place = [&](std::size_t i) -> Place {
    if (i == table.tiles.size()) return end;
    const Tile& tile = table.tiles[i];
    return {tile.first_reach, tile.first_block, tile.first_window, tile.first_line};
  };
  const Place begin = place(0);
  if (begin.reach + begin.block + begin.window + begin.line != 0) return false;
  for (std::size_t i = 0; i < table.tiles.size(); ++i) {
    const Place here = place(i);
    const Place next = place(i + 1);
    if (!rises(here, next) || next.block - here.block != table.tiles[i].block_count ||
        next.reach - here.reach != table.tiles[i].reach_count) {
      return false;
    }
  }
  std::atomic<bool> sound{true};
  pool.run(table.tiles_down, [&](int row) {
    for (int column = 0; column < table.tiles_across && sound; ++column) {
      const auto i = static_cast<std::size_t>(row * table.tiles_across + column);
      const Place here = place(i);
      const Place next = place(i + 1);
      const TileSpan span{table.tiles[i], table.reaches.subspan(here.reach, next.reach - here.reach),
                          table.blocks.subspan(here.block, next.block - here.block),
                          table.windows.subspan(here.window, next.window - here.window),
                          next.line - here.line};
      if (!TileCheck(table.views).passes(span)) sound = false;
    }
  });
  return sound;
}

}  // namespace cupola
