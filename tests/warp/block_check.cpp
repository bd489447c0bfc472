// Adds up the weights of every block, and the largest sums that texels could make of them.
// SPDX-License-Identifier: MIT
#include "tests/warp/block_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <set>

namespace cupola::test {
namespace {

int signed_byte(std::uint8_t byte) {
  return static_cast<std::int8_t>(byte);
}

bool fits_16_bits(int value) {
  return value >= INT16_MIN && value <= INT16_MAX;
}

// Sums of products over the texels that make them largest and smallest, without wrapping.
struct Extremes {
  std::int64_t least = 0;
  std::int64_t most = 0;

  void add(int weight, int least_texel, int most_texel) {
    least += std::int64_t{weight} * (weight < 0 ? most_texel : least_texel);
    most += std::int64_t{weight} * (weight < 0 ? least_texel : most_texel);
  }
  bool fit(std::int64_t bound) const { return least >= -bound && most <= bound; }
};

class BlockCheck {
 public:
  explicit BlockCheck(const WarpTable& table) : table_(table) {}

  void check(const Block& block, const Window*& window, const WeightLine*& line) {
    const WeightLine* first = line;
    std::int64_t narrow_rows = 0;
    for (std::uint32_t i = 0; i < block.window_count; ++i, ++window) {
      ASSERT_LT(window->view, table_.views.size());
      const Size view = table_.views[window->view];
      ASSERT_LE(window->x + kWindowSide, view.width);
      ASSERT_LE(window->y + kWindowSide, view.height);
      if (block.kind == BlockKind::kWide16) {
        ASSERT_LT(window->start[0], kPixelsInBlock);
        for (int at = 0; at < 64; ++at) add_pair(window->start[0], line, at);
        line += 2;
      } else {
        narrow_rows += window->rows;
        check_narrow(block.kind, *window, line);
      }
      if (testing::Test::HasFatalFailure()) return;
    }
    ASSERT_EQ(line - first, block.line_count);
    const bool bytes = block.kind == BlockKind::kNarrow8 || block.kind == BlockKind::kSigned8;
    const bool biased = block.kind == BlockKind::kSigned8;
    for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
      ASSERT_EQ(sum_[pixel], (block.covered >> pixel & 1) != 0 ? 1 << block.bits : 0);
      if (bytes) {
        // warp_table.h: within 2^17, and at most 255 * 128 * 4 texels * 8 rows a window with the bias.
        ASSERT_TRUE(high_[pixel].fit(biased ? std::int64_t{255} * 128 * kPatchWidth * narrow_rows : 1 << 17));
        ASSERT_TRUE(high_[pixel].fit(INT32_MAX));
      } else {
        const auto bound = std::int64_t{64} * 255 * std::min(taps_[pixel], kMostTaps);
        ASSERT_TRUE(high_[pixel].fit(bound) && low_[pixel].fit(bound));
        ASSERT_TRUE(high_[pixel].fit(INT32_MAX / 128));  // 128 high + low, kept in 32 bits
      }
    }
  }

 private:
  void add_pair(int pixel, const WeightLine* line, int at) {
    const int high = signed_byte(line[0].bytes[at]);
    const int low = signed_byte(line[1].bytes[at]);
    ASSERT_TRUE(high >= -64 && high <= 64 && low >= -64 && low < 64);
    sum_[pixel] += 128 * high + low;
    taps_[pixel] += high != 0 || low != 0 ? 1 : 0;
    high_[pixel].add(high, 0, 255);
    low_[pixel].add(low, 0, 255);
  }

  void check_narrow(BlockKind kind, const Window& window, const WeightLine*& line) {
    ASSERT_TRUE(window.rows >= 1 && window.rows <= kWindowSide && window.used <= kWindowSide);
    for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
      ASSERT_LE(window.start[pixel] % kWindowSide + kPatchWidth, kWindowSide);
      ASSERT_LE(window.start[pixel] / kWindowSide + window.rows, window.used);
      const int neighbour = window.start[pixel / kBlockSide * kBlockSide];
      ASSERT_LE(std::abs(window.start[pixel] / kWindowSide - neighbour / kWindowSide), window.spread);
    }
    for (int row = 0; row < window.rows; ++row) {
      for (int at = 0; at < 64; ++at) {
        const int pixel = at / kPatchWidth;
        if (kind == BlockKind::kNarrow16) {
          add_pair(pixel, line, at);
          continue;
        }
        sum_[pixel] += line->bytes[at] - (kind == BlockKind::kSigned8 ? kBias8 : 0);
        high_[pixel].add(line->bytes[at], -128, 127);
        if (at % 2 == 1) {
          const int pair = line->bytes[at] + line->bytes[at - 1];
          ASSERT_LE(pair, kMostPair8);
          ASSERT_TRUE(fits_16_bits(pair * -128) && fits_16_bits(pair * 127));
        }
      }
      line += kind == BlockKind::kNarrow16 ? 2 : 1;
    }
  }

  const WarpTable& table_;
  std::array<int, kPixelsInBlock> sum_{};
  std::array<int, kPixelsInBlock> taps_{};
  std::array<Extremes, kPixelsInBlock> high_{};  // kNarrow8, kSigned8: of the bytes as they are
  std::array<Extremes, kPixelsInBlock> low_{};
};

}  // namespace

void expect_sound(const WarpTable& table) {
  ASSERT_EQ(table.tiles.size(), static_cast<std::size_t>(table.tile_count()));
  for (const Tile& tile : table.tiles) {
    const Window* window = table.windows.data() + tile.first_window;
    const WeightLine* line = table.lines.data() + tile.first_line;
    std::set<int> places;
    int covered = 0;
    for (int i = 0; i < tile.block_count; ++i) {
      const Block& block = table.blocks[tile.first_block + i];
      ASSERT_TRUE(block.at < kBlocksInTile && places.insert(block.at).second);
      ASSERT_NE(block.covered, 0);
      covered += std::popcount(block.covered);
      BlockCheck(table).check(block, window, line);
      if (testing::Test::HasFatalFailure()) return;
    }
    ASSERT_EQ(tile.full, covered == kTileWidth * kTileHeight ? 1 : 0);
  }
}

}  // namespace cupola::test
