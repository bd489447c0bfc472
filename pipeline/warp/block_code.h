// A block of 16 pixels' integer weights, cut into windows and lines of the warp table.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pipeline/warp/warp_table.h"

namespace cupola {

struct IntegerTap {
  int x, y, view, weight;
};
using PixelTaps = std::vector<IntegerTap>;

struct BlockCode {
  Block block;  // kind and bits
  std::vector<Window> windows;
  std::vector<WeightLine> lines;
  std::size_t bytes() const { return windows.size() * sizeof(Window) + lines.size() * sizeof(WeightLine); }
};

// `kind` is any but kWide16. The weights of every pixel sum to 2^bits and are in the kind's range.
BlockCode encode_narrow(const std::array<PixelTaps, kPixelsInBlock>& block, std::span<const Size> views,
                        BlockKind kind, int bits);
BlockCode encode_wide(const std::array<PixelTaps, kPixelsInBlock>& block, std::span<const Size> views,
                      int bits);

}  // namespace cupola
