// The warp table: for every output pixel which texels it sums with which integer weights, laid out for SIMD.
//
// The frame is cut into tiles of 64 x 64 pixels, a tile into blocks of 4 x 4. A block sums one or more
// windows of 8 x 8 texels, each in one view. What a window holds for whom depends on the block's kind:
//
//   kNarrow8   One byte a weight; the weights of a pixel sum to 2^bits, 8 to 10 of them: the flatter a
//   block's
//              footprints, the more bits its largest weight leaves. Every pixel looks at a patch of its own
//              within the window, 4 texels wide and `rows` high, at `start`. One line of 64 weights a patch
//              row: 16 pixels in order, 4 weights each.
//   kNarrow16  The same with two bytes a weight, w = 128 high + low, in two lines a patch row (all high
//   bytes, then
//              all low ones); the weights of a pixel sum to 2^13, or 2^12 where the block has negative ones.
//   kWide16    The window belongs to one pixel, which sums all of it: two lines of 64 weights, row by row.
//
// Ranges. kNarrow8: weights 0..255, two neighbours in a row at most 256 together. Kernels use t' = t - 128 in
// [-128, 127] as the signed factor, so that a pair of products lies in [-2^15, 2^15 - 2^8], which fits 16
// bits with sign; a sum of all lies within 2^17. kNarrow16, kWide16: |w| <= 2^13 (with a sum of 2^12 real
// weights may reach 2), high and low in [-64, 64];
// a pair of products with unsigned texels is at most 2 * 64 * 255 = 32,640; the sums over a footprint of n
// texels stay below 64 * 255 * n, in 32 bits for n < 131,072; the builder refuses more.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/optics/needed_region.h"

namespace cupola {

inline constexpr int kTileSide = 64;  // pixels
inline constexpr int kBlockSide = 4;  // pixels
inline constexpr int kBlocksAcross = kTileSide / kBlockSide;
inline constexpr int kBlocksInTile = kBlocksAcross * kBlocksAcross;
inline constexpr int kPixelsInBlock = kBlockSide * kBlockSide;
inline constexpr int kWindowSide = 8;  // texels
inline constexpr int kPatchWidth = 4;  // texels

inline constexpr int kLeastBits8 = 8;  // weights of a kNarrow8 pixel sum to 2^8 ...
inline constexpr int kMostBits8 = 10;  // ... to 2^10
inline constexpr int kMostPair8 = 256;
inline constexpr int kBits16 = 13;        // weights of the other kinds sum to 2^13 ...
inline constexpr int kBitsSigned16 = 12;  // ... or, in a block with negative ones, to 2^12
inline constexpr int kMostTaps = 131071;

enum class BlockKind : std::uint8_t { kEmpty, kNarrow8, kNarrow16, kWide16 };

struct alignas(64) WeightLine {
  std::array<std::uint8_t, 64> bytes{};
};

struct Window {
  std::uint16_t x = 0;  // its top-left texel
  std::uint16_t y = 0;
  std::uint8_t view = 0;
  std::uint8_t rows = 0;   // narrow kinds: patch rows, 1..8
  std::uint8_t pixel = 0;  // kWide16: whose it is; windows of a pixel stand together, pixels rise
  std::uint8_t unused = 0;
  // Narrow kinds: 8 * row + column of each pixel's patch within the window; column <= 4, row + rows <= 8.
  std::array<std::uint8_t, kPixelsInBlock> start{};
};
static_assert(sizeof(Window) == 24);

struct Block {
  std::uint32_t first_window = 0;
  std::uint32_t first_line = 0;
  std::uint32_t window_count = 0;
  std::uint16_t covered = 0;  // bit i: pixel i has a footprint; the others are 0
  BlockKind kind = BlockKind::kEmpty;
  std::uint8_t bits = 0;  // the weights of every covered pixel sum to 2^bits
};
static_assert(sizeof(Block) == 16);

struct WarpTable {
  Size frame;
  std::vector<Size> views;  // at least 8 x 8: smaller ones are padded for the kernels
  int tiles_across = 0;
  int tiles_down = 0;
  std::vector<Block> blocks;  // tile by tile, row by row within each
  std::vector<Window> windows;
  std::vector<WeightLine> lines;

  // What went in, for reports.
  std::int64_t pixels_in_image = 0;
  std::int64_t pixels_uncovered = 0;
  std::int64_t taps = 0;
  std::array<std::int64_t, 4> blocks_of_kind{};
  std::vector<NeededRegion> needed;  // texels with a weight, view by view

  int tile_count() const { return tiles_across * tiles_down; }
  std::size_t bytes() const {
    return blocks.size() * sizeof(Block) + windows.size() * sizeof(Window) +
           lines.size() * sizeof(WeightLine);
  }
};

}  // namespace cupola
