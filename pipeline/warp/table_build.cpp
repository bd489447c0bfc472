// Footprints -> integer weights -> windows, block by block, a tile a task.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/table_build.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <tuple>

#include "pipeline/frame/error.h"
#include "pipeline/warp/block_code.h"
#include "pipeline/warp/footprint.h"
#include "pipeline/warp/quantise.h"
#include "pipeline/warp/symmetry.h"

namespace cupola {
namespace {

struct TileCode {
  Tile tile;
  std::vector<Reach> reaches;
  std::vector<Block> blocks;
  std::vector<Window> windows;
  std::vector<WeightLine> lines;
  std::int64_t in_image = 0;
  std::int64_t uncovered = 0;
  std::int64_t taps = 0;
};

// Rounding n weights to 2^-bits errs by sqrt(n / 12) 2^-bits of full scale, as a standard deviation over
// noise of spread 1. One byte a weight is used while that stays below this.
constexpr double kMostNoise8 = 0.0045;
constexpr double kMostSignedNoise8 = 0.0095;
// Past this many, patches 4 texels wide are never the smaller code.
constexpr std::size_t kMostNarrowTaps = 64;

// The forms of one byte a weight.
struct ByteForm {
  BlockKind kind;
  int least_bits, most_bits;
  int least, most;  // weights
  int most_pair;
  double most_noise;
};
constexpr ByteForm kUnsignedBytes{BlockKind::kNarrow8, kLeastBits8, kMostBits8, 0, 255,
                                  kMostPair8,          kMostNoise8};
constexpr ByteForm kSignedBytes{BlockKind::kSigned8,     kLeastSignedBits8, kMostSignedBits8, -kBias8,
                                kMostPair8 - 2 * kBias8,  // beside a tap without weight
                                kMostPair8 - 2 * kBias8, kMostSignedNoise8};

// How many of the frame's pixels pixel (x, y) of the table stands for.
int multiplicity(const WarpTable& table, int x, int y) {
  const auto& [across, down, views] = table.reflections.front();
  return (across && 2 * x + 1 != table.frame.width ? 2 : 1) *
         (down && 2 * y + 1 != table.frame.height ? 2 : 1);
}

class TileBuilder {
 public:
  TileBuilder(const Rig& rig, const FootprintGatherer& gatherer, const WarpTable& table)
      : rig_(rig), gatherer_(gatherer), table_(table) {}

  TileCode build(int tile_x, int tile_y, std::span<NeededRegion> needed) {
    TileCode tile;
    std::vector<BlockCode> codes;
    int covered = 0;
    for (int i = 0; i < kBlocksInTile; ++i) {
      const int x = table_.left + tile_x * kTileWidth + i % kBlocksAcross * kBlockSide;
      const int y = table_.top + tile_y * kTileHeight + i / kBlocksAcross * kBlockSide;
      BlockCode code = build_block(x, y, tile, needed);
      for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
        if (footprints_[pixel].empty()) continue;
        code.block.covered = static_cast<std::uint16_t>(code.block.covered | 1 << pixel);
        ++covered;
      }
      if (code.block.covered == 0) continue;
      code.block.at = static_cast<std::uint8_t>(i);
      code.block.window_count = static_cast<std::uint32_t>(code.windows.size());
      code.block.line_count = static_cast<std::uint32_t>(code.lines.size());
      codes.push_back(std::move(code));
    }
    tile.tile.full = covered == kTileWidth * kTileHeight ? 1 : 0;
    tile.tile.block_count = static_cast<std::uint16_t>(codes.size());
    std::stable_sort(codes.begin(), codes.end(), [](const BlockCode& a, const BlockCode& b) {
      const auto order = [](const BlockCode& code) {
        const Window& first = code.windows.front();
        return std::make_tuple(code.block.kind, code.block.window_count, code.block.covered != kAllPixels,
                               (first.used + 1) / 2, first.rows, first.spread);
      };
      return order(a) < order(b);
    });
    for (const BlockCode& code : codes) {
      tile.blocks.push_back(code.block);
      tile.windows.insert(tile.windows.end(), code.windows.begin(), code.windows.end());
      tile.lines.insert(tile.lines.end(), code.lines.begin(), code.lines.end());
    }
    note_reaches(tile);
    return tile;
  }

 private:
  static void note_reaches(TileCode& tile) {
    std::array<Reach, kMostViews> reach_of;
    for (Reach& reach : reach_of) reach = {UINT16_MAX, UINT16_MAX, 0, 0, 0};
    for (const Window& window : tile.windows) {
      Reach& reach = reach_of[window.view];
      reach.x0 = std::min(reach.x0, window.x);
      reach.y0 = std::min(reach.y0, window.y);
      reach.x1 = static_cast<std::uint16_t>(std::max<int>(reach.x1, window.x + kWindowSide));
      reach.y1 = static_cast<std::uint16_t>(std::max<int>(reach.y1, window.y + window.used));
    }
    for (std::size_t view = 0; view < kMostViews; ++view) {
      reach_of[view].view = static_cast<std::uint16_t>(view);
      if (reach_of[view].x1 > 0) tile.reaches.push_back(reach_of[view]);
    }
    tile.tile.reach_count = static_cast<std::uint8_t>(tile.reaches.size());
  }

  BlockCode build_block(int x, int y, TileCode& tile, std::span<NeededRegion> needed) {
    std::size_t most_taps = 0;
    bool negative = false;
    std::array<int, kPixelsInBlock> stands_for{};
    for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
      std::vector<Tap>& taps = footprints_[pixel];
      taps.clear();
      const int px = x + pixel % kBlockSide;
      const int py = y + pixel / kBlockSide;
      if (px < 0 || py < 0 || px >= rig_.frame.size.width || py >= rig_.frame.size.height) continue;
      const Footprint found = gatherer_.gather(px, py, taps);
      if (found == Footprint::kOutside) continue;
      stands_for[pixel] = multiplicity(table_, px, py);
      tile.in_image += stands_for[pixel];
      if (found == Footprint::kUncovered) tile.uncovered += stands_for[pixel];
      if (taps.size() > kMostTaps) {
        throw InputError(
            fmt::format("pixel ({}, {}) covers {} texels, expected at most {}: use smaller faces", px, py,
                        taps.size(), kMostTaps));
      }
      most_taps = std::max(most_taps, taps.size());
      for (const Tap& tap : taps) negative = negative || tap.weight < 0.0;
    }
    if (most_taps == 0) return {};
    const ByteForm& bytes = negative ? kSignedBytes : kUnsignedBytes;
    const int bits8 = rig_.filter.table == TableForm::kFast ? round_to_bytes(bytes, most_taps) : 0;
    const int bits16 = negative ? kSignedBits16 : kBits16;
    if (bits8 == 0) round_weights(bits16, 1 << kBits16);
    for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
      tile.taps += static_cast<std::int64_t>(integers_[pixel].size()) * stands_for[pixel];
      for (const IntegerTap& tap : integers_[pixel]) include(tap, needed);
    }
    if (bits8 != 0) return encode_narrow(integers_, table_.views, bytes.kind, bits8);
    BlockCode wide = encode_wide(integers_, table_.views, bits16);
    if (most_taps > kMostNarrowTaps) return wide;
    BlockCode narrow = encode_narrow(integers_, table_.views, BlockKind::kNarrow16, bits16);
    return wide.bytes() < narrow.bytes() ? wide : narrow;
  }

  void include(const IntegerTap& tap, std::span<NeededRegion> needed) const {
    for (const Reflection& reflection : table_.reflections) {
      const Reflection::Partner& partner = reflection.views[static_cast<std::size_t>(tap.view)];
      NeededRegion& region = needed[partner.view];
      region.include(partner.flip_u ? region.size.width - 1 - tap.x : tap.x,
                     partner.flip_v ? region.size.height - 1 - tap.y : tap.y);
    }
  }

  // Rounds to one byte a weight with as many bits as all pixels can have; their number, 0 when too few.
  int round_to_bytes(const ByteForm& form, std::size_t most_taps) {
    for (int bits = form.most_bits; bits >= form.least_bits; --bits) {
      if (std::sqrt(static_cast<double>(most_taps) / 12.0) / (1 << bits) > form.most_noise) return 0;
      if (round_weights(bits, form.most) && fit(form)) return bits;
    }
    return 0;
  }

  // Whether all weights, and any two taps side by side, are in the form's range.
  bool fit(const ByteForm& form) const {
    for (const PixelTaps& taps : integers_) {
      for (const IntegerTap& a : taps) {
        if (a.weight < form.least) return false;
        for (const IntegerTap& b : taps) {
          if (b.view == a.view && b.y == a.y && b.x == a.x + 1 && a.weight + b.weight > form.most_pair)
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
  const WarpTable& table_;
  std::array<std::vector<Tap>, kPixelsInBlock> footprints_;
  std::array<PixelTaps, kPixelsInBlock> integers_;
  std::vector<int> weights_;
};

// The grid of tiles ends at the axes of symmetry.
void lay_out(WarpTable& table) {
  const Reflection& first = table.reflections.front();
  const int width = first.across ? (table.frame.width + 1) / 2 : table.frame.width;
  const int height = first.down ? (table.frame.height + 1) / 2 : table.frame.height;
  table.tiles_across = (width + kTileWidth - 1) / kTileWidth;
  table.tiles_down = (height + kTileHeight - 1) / kTileHeight;
  if (first.across) table.left = width - table.tiles_across * kTileWidth;
  if (first.down) table.top = height - table.tiles_down * kTileHeight;
}

void append(WarpTable& table, const TileCode& code) {
  Tile tile = code.tile;
  tile.first_block = static_cast<std::uint32_t>(table.blocks.size());
  tile.first_window = static_cast<std::uint32_t>(table.windows.size());
  tile.first_line = static_cast<std::uint32_t>(table.lines.size());
  tile.first_reach = static_cast<std::uint32_t>(table.reaches.size());
  table.tiles.push_back(tile);
  for (const Block& block : code.blocks) ++table.blocks_of_kind[static_cast<std::size_t>(block.kind)];
  table.reaches.insert(table.reaches.end(), code.reaches.begin(), code.reaches.end());
  table.blocks.insert(table.blocks.end(), code.blocks.begin(), code.blocks.end());
  table.windows.insert(table.windows.end(), code.windows.begin(), code.windows.end());
  table.lines.insert(table.lines.end(), code.lines.begin(), code.lines.end());
  table.pixels_in_image += code.in_image;
  table.pixels_uncovered += code.uncovered;
  table.taps += code.taps;
}

}  // namespace

WarpTable build_warp_table(const Rig& rig, WorkerPool& pool) {
  return build_warp_table(rig, find_reflections(rig), pool);
}

WarpTable build_warp_table(const Rig& rig, const std::vector<Reflection>& reflections, WorkerPool& pool) {
  WarpTable table;
  table.frame = rig.frame.size;
  for (const View& view : rig.views) {
    table.views.push_back({std::max(view.size.width, kWindowSide), std::max(view.size.height, kWindowSide)});
    table.needed.push_back(NeededRegion::none(view.size));
  }
  table.reflections = reflections;
  lay_out(table);
  const FootprintGatherer gatherer(rig);
  // A row of tiles at a time: each tile by itself in parallel, then laid end to end in order.
  std::vector<TileCode> row(static_cast<std::size_t>(table.tiles_across));
  std::mutex merging;
  for (int tile_y = 0; tile_y < table.tiles_down; ++tile_y) {
    pool.run(table.tiles_across, [&](int tile_x) {
      std::vector<NeededRegion> needed;
      for (const NeededRegion& region : table.needed) needed.push_back(NeededRegion::none(region.size));
      row[tile_x] = TileBuilder(rig, gatherer, table).build(tile_x, tile_y, needed);
      const std::lock_guard lock(merging);
      for (std::size_t view = 0; view < needed.size(); ++view) table.needed[view].include(needed[view]);
    });
    for (TileCode& tile : row) {
      append(table, tile);
      tile = {};
    }
  }
  return table;
}

}  // namespace cupola
