// Footprints -> integer weights -> windows, block by block, a tile a task.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/table_build.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <mutex>
#include <tuple>

#include "pipeline/frame/error.h"
#include "pipeline/warp/block_code.h"
#include "pipeline/warp/footprint.h"
#include "pipeline/warp/quantise.h"
#include "pipeline/warp/symmetry.h"
#include "pipeline/warp/table_file.h"

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
      : rig_(rig), gatherer_(gatherer), table_(table), encoder_(table.views) {}

  // `read` takes what the tile reads of each view, its mirror images left aside.
  TileCode build(int tile_x, int tile_y, std::span<NeededRegion> read) {
    TileCode tile;
    std::vector<Piece> pieces;
    TileCode in_place;  // the parts in the order of the blocks' places
    int covered = 0;
    for (int i = 0; i < kBlocksInTile; ++i) {
      const int x = table_.left + tile_x * kTileWidth + i % kBlocksAcross * kBlockSide;
      const int y = table_.top + tile_y * kTileHeight + i / kBlocksAcross * kBlockSide;
      if (!gather(x, y, tile)) continue;
      BlockCode& code = encode(tile, read);
      code.block.at = static_cast<std::uint8_t>(i);
      for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
        if (footprints_[pixel].empty()) continue;
        code.block.covered = static_cast<std::uint16_t>(code.block.covered | 1 << pixel);
        ++covered;
      }
      pieces.push_back({code.block, code.windows.front(), in_place.windows.size(), in_place.lines.size()});
      in_place.windows.insert(in_place.windows.end(), code.windows.begin(), code.windows.end());
      in_place.lines.insert(in_place.lines.end(), code.lines.begin(), code.lines.end());
    }
    tile.tile.full = covered == kTileWidth * kTileHeight ? 1 : 0;
    tile.tile.block_count = static_cast<std::uint16_t>(pieces.size());
    put_in_order(pieces, in_place, tile);
    note_reaches(tile);
    return tile;
  }

 private:
  // A block's code, and where its windows and lines begin.
  struct Piece {
    Block block;
    Window first;
    std::size_t window, line;
  };

  static void put_in_order(std::vector<Piece>& pieces, const TileCode& in_place, TileCode& tile) {
    std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
      const auto order = [](const Piece& piece) {
        return std::make_tuple(piece.block.kind, piece.block.window_count, piece.block.covered != kAllPixels,
                               (piece.first.used + 1) / 2, piece.first.rows, piece.first.spread);
      };
      return order(a) < order(b);
    });
    tile.blocks.reserve(pieces.size());
    tile.windows.reserve(in_place.windows.size());
    tile.lines.reserve(in_place.lines.size());
    for (const Piece& piece : pieces) {
      tile.blocks.push_back(piece.block);
      const auto window = in_place.windows.begin() + static_cast<std::ptrdiff_t>(piece.window);
      const auto line = in_place.lines.begin() + static_cast<std::ptrdiff_t>(piece.line);
      tile.windows.insert(tile.windows.end(), window, window + piece.block.window_count);
      tile.lines.insert(tile.lines.end(), line, line + piece.block.line_count);
    }
  }

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

  // The footprints of the block at (x, y); false when all are empty.
  bool gather(int x, int y, TileCode& tile) {
    most_taps_ = 0;
    for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
      std::vector<Tap>& taps = footprints_[pixel];
      taps.clear();
      stands_for_[pixel] = 0;
      const int px = x + pixel % kBlockSide;
      const int py = y + pixel / kBlockSide;
      if (px < 0 || py < 0 || px >= rig_.frame.size.width || py >= rig_.frame.size.height) continue;
      const Footprint found = gatherer_.gather(px, py, taps);
      if (found == Footprint::kOutside) continue;
      stands_for_[pixel] = multiplicity(table_, px, py);
      tile.in_image += stands_for_[pixel];
      if (found == Footprint::kUncovered) tile.uncovered += stands_for_[pixel];
      if (taps.size() > kMostTaps) {
        throw InputError(
            fmt::format("pixel ({}, {}) covers {} texels, expected at most {}: use smaller faces", px, py,
                        taps.size(), kMostTaps));
      }
      most_taps_ = std::max(most_taps_, taps.size());
    }
    return most_taps_ > 0;
  }

  BlockCode& encode(TileCode& tile, std::span<NeededRegion> read) {
    const Heaviest heaviest = find_heaviest();
    const ByteForm& bytes = heaviest.negative ? kSignedBytes : kUnsignedBytes;
    const int bits8 = rig_.filter.table != TableForm::kPrecise ? round_to_bytes(bytes, heaviest) : 0;
    int bits16 = heaviest.negative ? kSignedBits16 : kBits16;
    while (bits16 < kMostBits16 && heaviest.one * (2 << bits16) <= 1 << kBits16) ++bits16;
    if (bits8 == 0) round_weights(bits16, 1 << kBits16);
    for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
      tile.taps += static_cast<std::int64_t>(integers_[pixel].size()) * stands_for_[pixel];
      include(integers_[pixel], read);
    }
    if (bits8 != 0) {
      encoder_.encode_narrow(integers_, bytes.kind, bits8, narrow_);
      return narrow_;
    }
    encoder_.encode_wide(integers_, bits16, wide_);
    if (most_taps_ > kMostNarrowTaps) return wide_;
    encoder_.encode_narrow(integers_, BlockKind::kNarrow16, bits16, narrow_);
    return wide_.bytes() < narrow_.bytes() ? wide_ : narrow_;
  }

  // Taps come row by row: the first and the last of a row include those between.
  static void include(const PixelTaps& taps, std::span<NeededRegion> read) {
    for (std::size_t i = 0; i < taps.size(); ++i) {
      const IntegerTap& tap = taps[i];
      const bool first = i == 0 || taps[i - 1].y != tap.y || taps[i - 1].view != tap.view;
      const bool last = i + 1 == taps.size() || taps[i + 1].y != tap.y || taps[i + 1].view != tap.view;
      if (first || last) read[tap.view].include(tap.x, tap.y);
    }
  }

  // The block's largest weight, its sign left aside, and the largest sum of two taps side by side.
  struct Heaviest {
    double one = 0.0;
    double pair = 0.0;
    bool negative = false;
  };

  Heaviest find_heaviest() const {
    Heaviest heaviest;
    for (const std::vector<Tap>& taps : footprints_) {
      for (std::size_t i = 0; i < taps.size(); ++i) {
        const Tap& tap = taps[i];
        heaviest.negative = heaviest.negative || tap.weight < 0.0;
        heaviest.one = std::max(heaviest.one, std::abs(tap.weight));
        if (i > 0 && beside(taps[i - 1], tap)) {
          heaviest.pair = std::max(heaviest.pair, taps[i - 1].weight + tap.weight);
        }
      }
    }
    return heaviest;
  }

  // Rounds to one byte a weight with as many bits as all pixels can have; their number, 0 when too few.
  int round_to_bytes(const ByteForm& form, const Heaviest& heaviest) {
    // Rounding and what follows it take at most 2 from a weight, 3 from a pair: past that there is no need to
    // try.
    constexpr double kSlack = 4.0;
    for (int bits = form.most_bits; bits >= form.least_bits; --bits) {
      const double total = 1 << bits;
      if (std::sqrt(static_cast<double>(most_taps_) / 12.0) / total > form.most_noise) return 0;
      if (heaviest.one * total > form.most + kSlack || heaviest.pair * total > form.most_pair + kSlack)
        continue;
      if (round_weights(bits, form.most) && fit(form)) return bits;
    }
    return 0;
  }

  // Whether all weights, and any two taps side by side, are in the form's range.
  bool fit(const ByteForm& form) const {
    for (const PixelTaps& taps : integers_) {
      for (std::size_t i = 0; i < taps.size(); ++i) {
        if (taps[i].weight < form.least) return false;
        if (i > 0 && beside(taps[i - 1], taps[i]) && taps[i - 1].weight + taps[i].weight > form.most_pair) {
          return false;
        }
      }
    }
    return true;
  }

  // Footprints come row by row, from left to right.
  template <class AnyTap>
  static bool beside(const AnyTap& a, const AnyTap& b) {
    assert(a.view != b.view || a.y < b.y || (a.y == b.y && a.x < b.x));
    return a.x + 1 == b.x && a.y == b.y && a.view == b.view;
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
  BlockEncoder encoder_;
  // Of the block at hand.
  std::array<std::vector<Tap>, kPixelsInBlock> footprints_;
  std::array<int, kPixelsInBlock> stands_for_{};  // pixels of the frame
  std::size_t most_taps_ = 0;
  std::array<PixelTaps, kPixelsInBlock> integers_;
  BlockCode narrow_, wide_;
  std::vector<int> weights_;
};

// The tiles' parts laid end to end, in order.
void assemble(WarpTable& table, const Rig& rig, std::vector<TileCode>& codes, WorkerPool& pool) {
  TableCounts counts;
  for (TileCode& code : codes) {
    code.tile.first_block = static_cast<std::uint32_t>(counts.blocks);
    code.tile.first_window = static_cast<std::uint32_t>(counts.windows);
    code.tile.first_line = static_cast<std::uint32_t>(counts.lines);
    code.tile.first_reach = static_cast<std::uint32_t>(counts.reaches);
    counts.blocks += code.blocks.size();
    counts.windows += code.windows.size();
    counts.lines += code.lines.size();
    counts.reaches += code.reaches.size();
    for (const Block& block : code.blocks) ++table.blocks_of_kind[static_cast<std::size_t>(block.kind)];
    table.pixels_in_image += code.in_image;
    table.pixels_uncovered += code.uncovered;
    table.taps += code.taps;
  }
  const TableParts parts = allocate_parts(table, rig, counts);
  pool.run(static_cast<int>(codes.size()), [&](int i) {
    TileCode& code = codes[static_cast<std::size_t>(i)];
    parts.tiles[static_cast<std::size_t>(i)] = code.tile;
    std::ranges::copy(code.reaches, parts.reaches.begin() + code.tile.first_reach);
    std::ranges::copy(code.blocks, parts.blocks.begin() + code.tile.first_block);
    std::ranges::copy(code.windows, parts.windows.begin() + code.tile.first_window);
    std::ranges::copy(code.lines, parts.lines.begin() + code.tile.first_line);
    code = {};
  });
}

// What the stored part of the frame reads of each view, and what its mirror images read.
std::vector<NeededRegion> with_reflections(std::span<const NeededRegion> read, const WarpTable& table) {
  std::vector<NeededRegion> needed;
  for (const NeededRegion& region : read) needed.push_back(NeededRegion::none(region.size));
  for (const Reflection& reflection : table.reflections) {
    for (std::size_t view = 0; view < read.size(); ++view) {
      const Reflection::Partner& partner = reflection.views[view];
      const auto [width, height] = read[view].size;
      for (int y = 0; y < height; ++y) {
        const RowSpan& row = read[view].rows[static_cast<std::size_t>(y)];
        if (row.empty()) continue;
        const int there = partner.flip_v ? height - 1 - y : y;
        needed[partner.view].include(partner.flip_u ? width - row.last : row.first, there);
        needed[partner.view].include(partner.flip_u ? width - 1 - row.first : row.last - 1, there);
      }
    }
  }
  return needed;
}

}  // namespace

WarpTable build_warp_table(const Rig& rig, WorkerPool& pool) {
  return build_warp_table(rig, find_reflections(rig), pool);
}

WarpTable build_warp_table(const Rig& rig, const std::vector<Reflection>& reflections, WorkerPool& pool) {
  WarpTable table = table_head(rig, reflections);
  const FootprintGatherer gatherer(rig);
  std::vector<TileCode> codes(static_cast<std::size_t>(table.tile_count()));
  std::vector<NeededRegion> read = table.needed;
  std::mutex merging;
  pool.run(table.tile_count(), [&](int i) {
    std::vector<NeededRegion> of_tile;
    for (const NeededRegion& region : read) of_tile.push_back(NeededRegion::none(region.size));
    codes[static_cast<std::size_t>(i)] =
        TileBuilder(rig, gatherer, table).build(i % table.tiles_across, i / table.tiles_across, of_tile);
    const std::lock_guard lock(merging);
    for (std::size_t view = 0; view < read.size(); ++view) read[view].include(of_tile[view]);
  });
  table.needed = with_reflections(read, table);
  assemble(table, rig, codes, pool);
  seal(table, pool);
  return table;
}

}  // namespace cupola
