// Footprints -> integer weights -> windows, block by block, a tile a task.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/table_build.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include "pipeline/frame/error.h"
#include "pipeline/warp/footprint.h"
#include "pipeline/warp/quantise.h"

namespace cupola {
namespace {

// A pixel's weights rounded for one kind of block.
struct IntegerTap {
  int x, y, view, weight;
};
using PixelTaps = std::vector<IntegerTap>;

// Taps of one pixel that fit one patch: 4 texels wide, up to 8 high.
struct Patch {
  int pixel;
  int view;
  int x, y;  // top-left texel
  int rows;
  std::size_t first_tap, last_tap;  // in the block's patch taps
};

struct BlockCode {
  BlockKind kind = BlockKind::kEmpty;
  int bits = 0;
  std::uint16_t covered = 0;
  std::vector<Window> windows;
  std::vector<WeightLine> lines;
  std::size_t bytes() const { return windows.size() * sizeof(Window) + lines.size() * sizeof(WeightLine); }
};

struct TileCode {
  std::array<Block, kBlocksInTile> blocks;  // offsets within the tile
  std::vector<Window> windows;
  std::vector<WeightLine> lines;
  std::int64_t in_image = 0;
  std::int64_t uncovered = 0;
  std::int64_t taps = 0;
};

std::uint8_t high_byte(int weight) {
  return static_cast<std::uint8_t>((weight + 64) >> 7);
}
std::uint8_t low_byte(int weight) {
  return static_cast<std::uint8_t>(weight - (((weight + 64) >> 7) << 7));
}

// Splits a pixel's taps into patches, view by view, from the left in steps of 4 columns.
void cut_patches(int pixel, PixelTaps& taps, std::span<const Size> views, std::vector<IntegerTap>& patch_taps,
                 std::vector<Patch>& patches) {
  while (!taps.empty()) {
    const int view = taps.front().view;
    int x = views[view].width;
    int y = views[view].height;
    for (const IntegerTap& tap : taps) {
      if (tap.view == view) x = std::min(x, tap.x);
    }
    for (const IntegerTap& tap : taps) {
      if (tap.view == view && tap.x < x + kPatchWidth) y = std::min(y, tap.y);
    }
    x = std::min(x, views[view].width - kPatchWidth);
    Patch patch{pixel, view, x, y, 0, patch_taps.size(), 0};
    const auto in_patch = [&](const IntegerTap& tap) {
      return tap.view == view && tap.x >= x && tap.x < x + kPatchWidth && tap.y < y + kWindowSide;
    };
    for (const IntegerTap& tap : taps) {
      if (!in_patch(tap)) continue;
      patch.rows = std::max(patch.rows, tap.y - y + 1);
      patch_taps.push_back(tap);
    }
    patch.last_tap = patch_taps.size();
    patches.push_back(patch);
    std::erase_if(taps, in_patch);
  }
}

// A patch fits a window when its columns and rows lie within.
bool fits(const Patch& patch, int view, int x, int y) {
  return patch.view == view && patch.x >= x && patch.x + kPatchWidth <= x + kWindowSide && patch.y >= y &&
         patch.y + patch.rows <= y + kWindowSide;
}

// Calls visit(index) for the patches that a window at (x, y) takes: at most one of each pixel.
template <class Visit>
void for_each_taken(const std::vector<Patch>& patches, int view, int x, int y, Visit&& visit) {
  std::uint32_t taken = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const std::uint32_t bit = 1U << patches[i].pixel;
    if ((taken & bit) != 0 || !fits(patches[i], view, x, y)) continue;
    taken |= bit;
    visit(i);
  }
}

// The window about the first patch that takes the most.
struct Placement {
  int x = 0, y = 0;
  std::size_t taken = 0;
};

Placement place_window(const std::vector<Patch>& patches, Size view) {
  const Patch& first = patches.front();
  Placement best;
  const auto try_at = [&](int x, int y) {
    Placement here{std::clamp(x, 0, view.width - kWindowSide), std::clamp(y, 0, view.height - kWindowSide),
                   0};
    for_each_taken(patches, first.view, here.x, here.y, [&](std::size_t) { ++here.taken; });
    if (here.taken > best.taken) best = here;
    return best.taken == patches.size();
  };
  int least_x = first.x;
  int least_y = first.y;
  for (const Patch& patch : patches) {
    if (patch.view != first.view) continue;
    least_x = std::min(least_x, patch.x);
    least_y = std::min(least_y, patch.y);
  }
  if (try_at(least_x, least_y)) return best;
  for (int dy = 0; dy <= kWindowSide - first.rows; ++dy) {
    for (int dx = 0; dx <= kWindowSide - kPatchWidth; ++dx) {
      if (try_at(first.x - dx, first.y - dy)) return best;
    }
  }
  return best;
}

BlockCode encode_narrow(const std::array<PixelTaps, kPixelsInBlock>& block, std::span<const Size> views,
                        BlockKind kind, int bits) {
  BlockCode code;
  code.kind = kind;
  code.bits = bits;
  std::vector<IntegerTap> patch_taps;
  std::vector<Patch> patches;
  for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
    PixelTaps taps = block[pixel];
    cut_patches(pixel, taps, views, patch_taps, patches);
  }
  const int lines_a_row = kind == BlockKind::kNarrow8 ? 1 : 2;
  while (!patches.empty()) {
    const int view = patches.front().view;
    const Placement placed = place_window(patches, views[view]);
    Window window;
    window.x = static_cast<std::uint16_t>(placed.x);
    window.y = static_cast<std::uint16_t>(placed.y);
    window.view = static_cast<std::uint8_t>(view);
    std::vector<std::size_t> members;
    for_each_taken(patches, view, placed.x, placed.y, [&](std::size_t i) { members.push_back(i); });
    int rows = 0;
    for (const std::size_t i : members) rows = std::max(rows, patches[i].rows);
    window.rows = static_cast<std::uint8_t>(rows);
    const std::size_t first_line = code.lines.size();
    code.lines.resize(first_line + static_cast<std::size_t>(rows * lines_a_row));
    for (const std::size_t i : members) {
      const Patch& patch = patches[i];
      const int row = std::min(patch.y - placed.y, kWindowSide - rows);
      const int column = patch.x - placed.x;
      window.start[patch.pixel] = static_cast<std::uint8_t>(row * kWindowSide + column);
      for (std::size_t t = patch.first_tap; t < patch.last_tap; ++t) {
        const IntegerTap& tap = patch_taps[t];
        const int line = (tap.y - placed.y - row) * lines_a_row;
        const int at = patch.pixel * kPatchWidth + tap.x - patch.x;
        WeightLine* weights = &code.lines[first_line + static_cast<std::size_t>(line)];
        if (kind == BlockKind::kNarrow8) {
          weights[0].bytes[at] = static_cast<std::uint8_t>(tap.weight);
        } else {
          weights[0].bytes[at] = high_byte(tap.weight);
          weights[1].bytes[at] = low_byte(tap.weight);
        }
      }
    }
    code.windows.push_back(window);
    for (auto i = members.rbegin(); i != members.rend(); ++i) {
      patches.erase(patches.begin() + static_cast<std::ptrdiff_t>(*i));
    }
  }
  return code;
}

BlockCode encode_wide(const std::array<PixelTaps, kPixelsInBlock>& block, std::span<const Size> views,
                      int bits) {
  BlockCode code;
  code.kind = BlockKind::kWide16;
  code.bits = bits;
  for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
    PixelTaps taps = block[pixel];
    while (!taps.empty()) {
      const int view = taps.front().view;
      int x = views[view].width;
      int y = views[view].height;
      for (const IntegerTap& tap : taps) {
        if (tap.view == view) y = std::min(y, tap.y);
      }
      y = std::min(y, views[view].height - kWindowSide);
      for (const IntegerTap& tap : taps) {
        if (tap.view == view && tap.y < y + kWindowSide) x = std::min(x, tap.x);
      }
      x = std::min(x, views[view].width - kWindowSide);
      Window window;
      window.x = static_cast<std::uint16_t>(x);
      window.y = static_cast<std::uint16_t>(y);
      window.view = static_cast<std::uint8_t>(view);
      window.pixel = static_cast<std::uint8_t>(pixel);
      std::array<WeightLine, 2> lines;
      std::erase_if(taps, [&](const IntegerTap& tap) {
        const int column = tap.x - x;
        const int row = tap.y - y;
        if (tap.view != view || column < 0 || column >= kWindowSide || row < 0 || row >= kWindowSide)
          return false;
        lines[0].bytes[row * kWindowSide + column] = high_byte(tap.weight);
        lines[1].bytes[row * kWindowSide + column] = low_byte(tap.weight);
        return true;
      });
      code.windows.push_back(window);
      code.lines.insert(code.lines.end(), lines.begin(), lines.end());
    }
  }
  return code;
}

// Rounding n weights to 2^-bits errs by sqrt(n / 12) 2^-bits of full scale, as a standard deviation over
// noise of spread 1. One byte a weight is used while that stays below this.
constexpr double kMostNoise8 = 0.0045;
// Past this many, patches 4 texels wide are never the smaller code.
constexpr std::size_t kMostNarrowTaps = 64;

class TileBuilder {
 public:
  TileBuilder(const Rig& rig, const FootprintGatherer& gatherer, std::span<const Size> views)
      : rig_(rig), gatherer_(gatherer), views_(views) {}

  TileCode build(int tile_x, int tile_y, std::span<NeededRegion> needed) {
    TileCode tile;
    for (int i = 0; i < kBlocksInTile; ++i) {
      const int x = tile_x * kTileSide + i % kBlocksAcross * kBlockSide;
      const int y = tile_y * kTileSide + i / kBlocksAcross * kBlockSide;
      BlockCode code = build_block(x, y, tile, needed);
      for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
        code.covered =
            static_cast<std::uint16_t>(code.covered | (footprints_[pixel].empty() ? 0 : 1) << pixel);
      }
      Block& block = tile.blocks[i];
      block.kind = code.kind;
      block.bits = static_cast<std::uint8_t>(code.bits);
      block.covered = code.covered;
      block.first_window = static_cast<std::uint32_t>(tile.windows.size());
      block.first_line = static_cast<std::uint32_t>(tile.lines.size());
      block.window_count = static_cast<std::uint32_t>(code.windows.size());
      tile.windows.insert(tile.windows.end(), code.windows.begin(), code.windows.end());
      tile.lines.insert(tile.lines.end(), code.lines.begin(), code.lines.end());
    }
    return tile;
  }

 private:
  BlockCode build_block(int x, int y, TileCode& tile, std::span<NeededRegion> needed) {
    std::size_t most_taps = 0;
    for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
      std::vector<Tap>& taps = footprints_[pixel];
      taps.clear();
      const int px = x + pixel % kBlockSide;
      const int py = y + pixel / kBlockSide;
      if (px >= rig_.frame.size.width || py >= rig_.frame.size.height) continue;
      const Footprint found = gatherer_.gather(px, py, taps);
      if (found == Footprint::kOutside) continue;
      ++tile.in_image;
      if (found == Footprint::kUncovered) ++tile.uncovered;
      if (taps.size() > kMostTaps) {
        throw InputError(
            fmt::format("pixel ({}, {}) covers {} texels, expected at most {}: use smaller faces", px, py,
                        taps.size(), kMostTaps));
      }
      most_taps = std::max(most_taps, taps.size());
    }
    if (most_taps == 0) return {};
    const bool positive = all_positive();
    int bits = rig_.filter.table == TableForm::kFast && positive ? round_to_bytes(most_taps) : 0;
    const bool eight_bits = bits != 0;
    if (!eight_bits) {
      bits = positive ? kBits16 : kBitsSigned16;
      round_weights(bits, 1 << kBits16);
    }
    for (const PixelTaps& taps : integers_) {
      tile.taps += static_cast<std::int64_t>(taps.size());
      for (const IntegerTap& tap : taps) needed[tap.view].include(tap.x, tap.y);
    }
    if (eight_bits) return encode_narrow(integers_, views_, BlockKind::kNarrow8, bits);
    BlockCode wide = encode_wide(integers_, views_, bits);
    if (most_taps > kMostNarrowTaps) return wide;
    BlockCode narrow = encode_narrow(integers_, views_, BlockKind::kNarrow16, bits);
    return wide.bytes() < narrow.bytes() ? wide : narrow;
  }

  bool all_positive() const {
    return std::ranges::all_of(footprints_, [](const std::vector<Tap>& taps) {
      return std::ranges::all_of(taps, [](const Tap& tap) { return tap.weight >= 0.0; });
    });
  }

  // Rounds to one byte a weight with as many bits as all pixels can have; their number, 0 when too few.
  int round_to_bytes(std::size_t most_taps) {
    for (int bits = kMostBits8; bits >= kLeastBits8; --bits) {
      if (std::sqrt(static_cast<double>(most_taps) / 12.0) / (1 << bits) > kMostNoise8) return 0;
      if (round_weights(bits, 255) && pairs_fit()) return bits;
    }
    return 0;
  }

  // Whether any two taps side by side sum to at most kMostPair8 (warp_table.h, ranges).
  bool pairs_fit() const {
    for (const PixelTaps& taps : integers_) {
      for (const IntegerTap& a : taps) {
        for (const IntegerTap& b : taps) {
          if (b.view == a.view && b.y == a.y && b.x == a.x + 1 && a.weight + b.weight > kMostPair8)
            return false;
        }
      }
    }
    return true;
  }

  bool round_weights(int bits, int most) {
    for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
      const std::vector<Tap>& taps = footprints_[pixel];
      PixelTaps& integers = integers_[pixel];
      integers.clear();
      if (taps.empty()) continue;
      if (!quantise(taps, 1 << bits, most, weights_)) return false;
      for (std::size_t i = 0; i < taps.size(); ++i) {
        if (weights_[i] != 0) integers.push_back({taps[i].x, taps[i].y, taps[i].view, weights_[i]});
      }
    }
    return true;
  }

  const Rig& rig_;
  const FootprintGatherer& gatherer_;
  std::span<const Size> views_;
  std::array<std::vector<Tap>, kPixelsInBlock> footprints_;
  std::array<PixelTaps, kPixelsInBlock> integers_;
  std::vector<int> weights_;
};

}  // namespace

WarpTable build_warp_table(const Rig& rig, WorkerPool& pool) {
  WarpTable table;
  table.frame = rig.frame.size;
  for (const View& view : rig.views) {
    table.views.push_back({std::max(view.size.width, kWindowSide), std::max(view.size.height, kWindowSide)});
    table.needed.push_back(NeededRegion::none(view.size));
  }
  table.tiles_across = (rig.frame.size.width + kTileSide - 1) / kTileSide;
  table.tiles_down = (rig.frame.size.height + kTileSide - 1) / kTileSide;
  table.blocks.reserve(static_cast<std::size_t>(table.tile_count()) * kBlocksInTile);
  const FootprintGatherer gatherer(rig);
  // A row of tiles at a time: each tile by itself in parallel, then laid end to end in order.
  std::vector<TileCode> row(static_cast<std::size_t>(table.tiles_across));
  std::mutex merging;
  for (int tile_y = 0; tile_y < table.tiles_down; ++tile_y) {
    pool.run(table.tiles_across, [&](int tile_x) {
      std::vector<NeededRegion> needed;
      for (const NeededRegion& region : table.needed) needed.push_back(NeededRegion::none(region.size));
      TileBuilder builder(rig, gatherer, table.views);
      row[tile_x] = builder.build(tile_x, tile_y, needed);
      const std::lock_guard lock(merging);
      for (std::size_t view = 0; view < needed.size(); ++view) table.needed[view].include(needed[view]);
    });
    for (TileCode& tile : row) {
      for (Block block : tile.blocks) {
        block.first_window += static_cast<std::uint32_t>(table.windows.size());
        block.first_line += static_cast<std::uint32_t>(table.lines.size());
        ++table.blocks_of_kind[static_cast<std::size_t>(block.kind)];
        table.blocks.push_back(block);
      }
      table.windows.insert(table.windows.end(), tile.windows.begin(), tile.windows.end());
      table.lines.insert(table.lines.end(), tile.lines.begin(), tile.lines.end());
      table.pixels_in_image += tile.in_image;
      table.pixels_uncovered += tile.uncovered;
      table.taps += tile.taps;
      tile = {};
    }
  }
  return table;
}

}  // namespace cupola
