// The warp table: for every output pixel which texels it sums with which integer weights, laid out for SIMD.
//
// The frame is cut into tiles of 64 x 32 pixels, a tile into blocks of 4 x 4. A block sums one or more
// windows of 8 x 8 texels, each in one view. What a window holds for whom depends on the block's kind:
//
//   kNarrow8   One byte a weight; the weights of a pixel sum to 2^bits, 8 to 10 of them: the flatter a
//              block's footprints, the more bits its largest weight leaves. Every pixel looks at a patch of
//              its own within the window, 4 texels wide and `rows` high, at `start`. One line of 64 weights a
//              patch row: 16 pixels in order, 4 weights each.
//   kSigned8   The same for filters with negative lobes: a byte is the weight plus kBias8, everywhere, and
//              the weights of a pixel sum to 2^bits, 7 to 9 of them.
//   kNarrow16  The same with two bytes a weight, w = 128 high + low, in two lines a patch row (all high
//              bytes, then all low ones); the weights of a pixel sum to 2^13, signed ones to 2^12, or to
//              up to 2^17 where the block's heaviest weight still is at most 2^13.
//   kWide16    The window belongs to one pixel, which sums all of it: two lines of 64 weights, row by row.
//
// Ranges. kNarrow8, kSigned8: bytes 0..255, two neighbours in a row at most 256 together. Kernels use
// t' = t - 128 in [-128, 127] as the signed factor, so that a pair of products lies in [-2^15, 2^15 - 2^8],
// which fits 16 bits with sign; a sum of all lies within 2^17 (2^18 with the bias, at most 255 * 128 * 4
// texels * 8 rows a window). kNarrow16, kWide16: |w| <= 2^13, high and low in [-64, 64]; a pair of products
// with unsigned texels is at most 2 * 64 * 255 = 32,640; the sums over a footprint of n texels stay below
// 64 * 255 * n, in 32 bits for n < 131,072; the builder refuses more. |high| <= |w| / 64, and the |w| of a
// pixel sum to at most 3 * 2^17, so that 128 times the sum of high bytes stays below 2^28.
//
// Symmetry. Where the rig is its own mirror image, left to right or top to bottom, the table holds one half
// or one quarter of the frame, and every block serves two or four places (`reflections`). The grid of tiles
// then ends at the axis of symmetry and may begin before the frame does.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/frame/mapped_bytes.h"
#include "pipeline/optics/needed_region.h"

namespace cupola {

inline constexpr int kTileWidth = 64;   // pixels
inline constexpr int kTileHeight = 32;  // pixels
inline constexpr int kBlockSide = 4;    // pixels
inline constexpr int kBlocksAcross = kTileWidth / kBlockSide;
inline constexpr int kBlocksInTile = kBlocksAcross * (kTileHeight / kBlockSide);
inline constexpr int kPixelsInBlock = kBlockSide * kBlockSide;
inline constexpr int kWindowSide = 8;  // texels
inline constexpr int kPatchWidth = 4;  // texels
inline constexpr std::size_t kMostViews = 6;
inline constexpr std::uint16_t kAllPixels = 0xffff;

inline constexpr int kLeastBits8 = 8;  // weights of a kNarrow8 pixel sum to 2^8 ...
inline constexpr int kMostBits8 = 10;  // ... to 2^10
inline constexpr int kLeastSignedBits8 = 7;
inline constexpr int kMostSignedBits8 = 9;
inline constexpr int kBias8 = 32;
inline constexpr int kMostPair8 = 256;
inline constexpr int kBits16 = 13;        // weights of the other kinds sum to 2^13,
inline constexpr int kSignedBits16 = 12;  // to 2^12 with negative ones among them,
inline constexpr int kMostBits16 = 17;    // to as much as this where all are light
inline constexpr int kMostTaps = 131071;

enum class BlockKind : std::uint8_t { kNarrow8, kSigned8, kNarrow16, kWide16 };
inline constexpr std::size_t kBlockKinds = 4;

struct alignas(64) WeightLine {
  std::array<std::uint8_t, 64> bytes{};
};

struct Window {
  std::uint16_t x = 0;  // its top-left texel
  std::uint16_t y = 0;
  std::uint8_t view = 0;
  std::uint8_t rows = 0;  // narrow kinds: patch rows, 1..8
  std::uint8_t used = 0;  // rows of the window that hold a patch's, from the top; the others need no loading
  std::uint8_t spread = 0;  // narrow kinds: rows between the starts of a block row's pixels, at most
  // Narrow kinds: 8 * row + column of each pixel's patch within the window; column <= 4, row + rows <= used.
  // kWide16: the first is the pixel whose it is; windows of a pixel stand together, pixels rise.
  std::array<std::uint8_t, kPixelsInBlock> start{};
};
static_assert(sizeof(Window) == 24);

// Windows and lines of a tile's blocks follow one another in the order of the blocks. Blocks without a
// footprint are left out; their pixels are black.
struct Block {
  std::uint32_t window_count = 0;
  std::uint32_t line_count = 0;
  std::uint16_t covered = 0;  // bit i: pixel i has a footprint; the others are 0
  std::uint8_t at = 0;        // place in the tile, row by row
  BlockKind kind = BlockKind::kNarrow8;
  std::uint32_t bits = 0;  // the weights of every covered pixel sum to 2^bits
};
static_assert(sizeof(Block) == 16);

// The texels [x0, x1) x [y0, y1) of a view that a tile's windows touch.
struct Reach {
  std::uint16_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  std::uint16_t view = 0;
};
static_assert(sizeof(Reach) == 10);

// Blocks are ordered by kind, windows and rows, not by place: what a processor does next is then what it did
// last.
struct Tile {
  std::uint32_t first_block = 0;
  std::uint32_t first_window = 0;
  std::uint32_t first_line = 0;
  std::uint32_t first_reach = 0;
  std::uint16_t block_count = 0;
  std::uint8_t reach_count = 0;  // one a view
  std::uint8_t full = 0;         // 1: every pixel of the tile has a footprint
};
static_assert(sizeof(Tile) == 20);

// One of the frame's mirror images. What view v gives a pixel, views[v].view gives the pixel's mirror image,
// with its texels mirrored as said.
struct Reflection {
  struct Partner {
    std::uint8_t view = 0;
    bool flip_u = false;
    bool flip_v = false;
  };
  bool across = false;  // pixel (x, y) goes to (width - 1 - x, y)
  bool down = false;    // ... to (x, height - 1 - y)
  std::array<Partner, kMostViews> views{};
};

// Made by the builder or read from a file, and then the same.
struct WarpTable {
  // Follow from the rig.
  Size frame;
  std::vector<Size> views;  // at least 8 x 8: smaller ones are padded for the kernels
  int left = 0;             // frame pixel of the first tile's corner; 0 or less
  int top = 0;
  int tiles_across = 0;
  int tiles_down = 0;
  std::vector<Reflection> reflections;  // 1, 2 or 4; the first has all mirrors, the last none

  // Lie in `memory`.
  std::span<const Tile> tiles;  // row by row
  std::span<const Reach> reaches;
  std::span<const Block> blocks;
  std::span<const Window> windows;
  std::span<const WeightLine> lines;

  // What went in, of the whole frame, for reports.
  std::int64_t pixels_in_image = 0;
  std::int64_t pixels_uncovered = 0;
  std::int64_t taps = 0;
  std::array<std::int64_t, kBlockKinds> blocks_of_kind{};  // as stored
  std::vector<NeededRegion> needed;                        // texels with a weight, view by view

  MappedBytes memory;  // all of it as table_file.h has it

  int tile_count() const { return tiles_across * tiles_down; }
  std::size_t bytes() const {
    return tiles.size_bytes() + reaches.size_bytes() + blocks.size_bytes() + windows.size_bytes() +
           lines.size_bytes();
  }
};

}  // namespace cupola
