// Warp tables that no rig would give: every kind of block, with all that warp_table.h allows and at its
// limits.
// SPDX-License-Identifier: MIT
#pragma once

#include <random>
#include <span>
#include <vector>

#include "pipeline/warp/warp_table.h"

namespace cupola::test {

using Random = std::mt19937;

// least..most
int between(Random& random, int least, int most);

// A table and the memory of its parts.
struct RandomTable {
  std::vector<Tile> tiles;
  std::vector<Block> blocks;
  std::vector<Window> windows;
  std::vector<WeightLine> lines;
  WarpTable table;
};

// A table of `tiles` tiles over views of the given sizes; a tile holds some blocks of some of `kinds`.
RandomTable random_table(Random& random, std::span<const BlockKind> kinds, std::vector<Size> views,
                         int tiles);

}  // namespace cupola::test
