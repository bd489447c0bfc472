// Weights are drawn, mostly at the limits of their range, then moved until every pixel's sum is right.
// SPDX-License-Identifier: MIT
#include "tests/warp/random_table.h"

#include <algorithm>
#include <numeric>

namespace cupola::test {

int between(Random& random, int least, int most) {
  return std::uniform_int_distribution<>(least, most)(random);
}

namespace {

// A block in the making: weights as numbers, a line after another.
struct Draft {
  Block block;
  std::vector<Window> windows;
  std::vector<std::array<int, 64>> weights;
};

// One pixel's weights: where they lie in a draft.
using Slots = std::vector<int*>;

struct Range {
  int least, most;
  int most_pair;  // of neighbours; slots come in pairs
};

Range range_of(BlockKind kind) {
  if (kind == BlockKind::kNarrow8) return {0, 255, kMostPair8};
  if (kind == BlockKind::kSigned8) return {-kBias8, 255 - kBias8, kMostPair8 - 2 * kBias8};
  return {-(1 << kBits16), 1 << kBits16, 2 << kBits16};
}

int drawn(Random& random, const Range& range) {
  switch (between(random, 0, 4)) {
    case 0:
      return range.least;
    case 1:
      return range.most;
    case 2:
      return between(random, range.least, range.most);
    default:
      return 0;
  }
}

// Draws weights that sum to `sum`, a pair at a time; `sum` must be possible.
void fill(Random& random, const Slots& slots, const Range& range, int sum) {
  std::vector<std::size_t> order(slots.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), random);
  for (const std::size_t i : order)
    *slots[i] = std::min(drawn(random, range), range.most_pair - *slots[i ^ 1]);
  int missing = sum;
  for (const int* weight : slots) missing -= *weight;
  for (const std::size_t i : order) {
    const int most = std::min(range.most, range.most_pair - *slots[i ^ 1]);
    const int moved = std::clamp(*slots[i] + missing, range.least, most);
    missing -= moved - *slots[i];
    *slots[i] = moved;
  }
}

Window random_window(Random& random, const std::vector<Size>& views) {
  Window window;
  window.view = static_cast<std::uint8_t>(between(random, 0, static_cast<int>(views.size()) - 1));
  const auto place = [&](int side) {  // often at an edge
    const int most = side - kWindowSide;
    return static_cast<std::uint16_t>(
        std::clamp(between(random, -most / 2 - 1, most + most / 2 + 1), 0, most));
  };
  window.x = place(views[window.view].width);
  window.y = place(views[window.view].height);
  return window;
}

void set_starts(Random& random, Window& window) {
  window.rows = static_cast<std::uint8_t>(between(random, 1, kWindowSide));
  const int lowest = kWindowSide - window.rows;
  const int spread = std::min(lowest, between(random, 0, kWindowSide - 1));
  for (int row = 0; row < kPixelsInBlock; row += kBlockSide) {
    const int first = between(random, 0, lowest - spread);
    int least = kWindowSide;
    int most = 0;
    for (int pixel = row; pixel < row + kBlockSide; ++pixel) {
      const int at = between(random, first, first + spread);
      least = std::min(least, at);
      most = std::max(most, at);
      window.start[pixel] = static_cast<std::uint8_t>(at * kWindowSide + between(random, 0, kPatchWidth));
    }
    window.spread = static_cast<std::uint8_t>(std::max<int>(window.spread, most - least));
    window.used = static_cast<std::uint8_t>(std::max<int>(window.used, most + window.rows));
  }
}

Slots slots_of(Draft& draft, int pixel) {
  Slots slots;
  std::size_t line = 0;
  for (const Window& window : draft.windows) {
    if (draft.block.kind == BlockKind::kWide16) {
      if (window.start[0] == pixel) {
        for (int& weight : draft.weights[line]) slots.push_back(&weight);
      }
      ++line;
      continue;
    }
    for (int row = 0; row < window.rows; ++row, ++line) {
      for (int k = 0; k < kPatchWidth; ++k) slots.push_back(&draft.weights[line][pixel * kPatchWidth + k]);
    }
  }
  return slots;
}

Draft random_block(Random& random, BlockKind kind, const std::vector<Size>& views) {
  Draft draft;
  draft.block.kind = kind;
  draft.block.covered =
      between(random, 0, 1) == 0 ? kAllPixels : static_cast<std::uint16_t>(between(random, 1, kAllPixels));
  if (kind == BlockKind::kWide16) {
    for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
      if ((draft.block.covered >> pixel & 1) == 0) continue;
      for (int i = between(random, 1, 3); i > 0; --i) {
        Window window = random_window(random, views);
        window.used = kWindowSide;
        window.start[0] = static_cast<std::uint8_t>(pixel);
        draft.windows.push_back(window);
        draft.weights.emplace_back();
      }
    }
  } else {
    for (int i = std::max(1, between(random, -2, 4)); i > 0; --i) {
      draft.windows.push_back(random_window(random, views));
      set_starts(random, draft.windows.back());
      draft.weights.resize(draft.weights.size() + draft.windows.back().rows);
    }
  }
  const Range range = range_of(kind);
  const int most_sum = static_cast<int>(draft.weights.size()) * kPatchWidth / 2 * range.most_pair;
  int bits = between(random, kSignedBits16, kMostBits16);
  if (kind == BlockKind::kNarrow8) bits = between(random, kLeastBits8, kMostBits8);
  if (kind == BlockKind::kSigned8) bits = between(random, kLeastSignedBits8, kMostSignedBits8);
  while (1 << bits > most_sum) --bits;
  draft.block.bits = static_cast<std::uint8_t>(bits);
  for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
    if ((draft.block.covered >> pixel & 1) != 0) fill(random, slots_of(draft, pixel), range, 1 << bits);
  }
  return draft;
}

void add_lines(const Draft& draft, std::vector<WeightLine>& lines) {
  for (const auto& weights : draft.weights) {
    WeightLine first;
    WeightLine second;
    for (std::size_t at = 0; at < weights.size(); ++at) {
      if (draft.block.kind == BlockKind::kNarrow8 || draft.block.kind == BlockKind::kSigned8) {
        const int bias = draft.block.kind == BlockKind::kSigned8 ? kBias8 : 0;
        first.bytes[at] = static_cast<std::uint8_t>(weights[at] + bias);
      } else {
        const int high = (weights[at] + 64) >> 7;
        first.bytes[at] = static_cast<std::uint8_t>(high);
        second.bytes[at] = static_cast<std::uint8_t>(weights[at] - high * 128);
      }
    }
    lines.push_back(first);
    if (draft.block.kind == BlockKind::kNarrow16 || draft.block.kind == BlockKind::kWide16) {
      lines.push_back(second);
    }
  }
}

}  // namespace

RandomTable random_table(Random& random, std::span<const BlockKind> kinds, std::vector<Size> views,
                         int tiles) {
  RandomTable parts;
  WarpTable& table = parts.table;
  table.frame = {tiles * kTileWidth, kTileHeight};
  table.views = std::move(views);
  table.tiles_across = tiles;
  table.tiles_down = 1;
  table.reflections.resize(1);
  for (int i = 0; i < tiles; ++i) {
    Tile tile;
    tile.first_block = static_cast<std::uint32_t>(parts.blocks.size());
    tile.first_window = static_cast<std::uint32_t>(parts.windows.size());
    tile.first_line = static_cast<std::uint32_t>(parts.lines.size());
    tile.block_count = static_cast<std::uint16_t>(between(random, 1, 24));
    std::vector<std::uint8_t> places(kBlocksInTile);
    std::iota(places.begin(), places.end(), std::uint8_t{0});
    std::shuffle(places.begin(), places.end(), random);
    for (std::size_t b = 0; b < tile.block_count; ++b) {
      const auto kind =
          kinds[static_cast<std::size_t>(between(random, 0, static_cast<int>(kinds.size()) - 1))];
      Draft draft = random_block(random, kind, table.views);
      const std::size_t first_line = parts.lines.size();
      add_lines(draft, parts.lines);
      draft.block.at = places[b];
      draft.block.window_count = static_cast<std::uint32_t>(draft.windows.size());
      draft.block.line_count = static_cast<std::uint32_t>(parts.lines.size() - first_line);
      parts.blocks.push_back(draft.block);
      parts.windows.insert(parts.windows.end(), draft.windows.begin(), draft.windows.end());
    }
    parts.tiles.push_back(tile);
  }
  table.tiles = parts.tiles;
  table.blocks = parts.blocks;
  table.windows = parts.windows;
  table.lines = parts.lines;
  return parts;
}

}  // namespace cupola::test
