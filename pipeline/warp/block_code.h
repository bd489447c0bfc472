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
  Block block;  // kind, bits and counts
  std::vector<Window> windows;
  std::vector<WeightLine> lines;
  std::size_t bytes() const { return windows.size() * sizeof(Window) + lines.size() * sizeof(WeightLine); }
};

// Encodes block after block into memory that it keeps.
class BlockEncoder {
 public:
  explicit BlockEncoder(std::span<const Size> views) : views_(views) {}  // borrowed

  // `kind` is any but kWide16. The weights of every pixel sum to 2^bits and are in the kind's range.
  void encode_narrow(const std::array<PixelTaps, kPixelsInBlock>& block, BlockKind kind, int bits,
                     BlockCode& code);
  void encode_wide(const std::array<PixelTaps, kPixelsInBlock>& block, int bits, BlockCode& code);

 private:
  // Taps of one pixel that fit one patch: 4 texels wide, up to 8 high.
  struct Patch {
    int pixel;
    int view;
    int x, y;  // top-left texel
    int columns, rows;
    std::size_t first_tap, last_tap;  // in patch_taps_
  };
  struct Placement;

  void cut_patches(int pixel, const PixelTaps& taps);
  bool is_one_patch(int pixel, const PixelTaps& taps);
  template <class Visit>
  void for_each_taken(int view, int x, int y, Visit&& visit) const;
  Placement place_window() const;
  void write_weights(const Patch& patch, const Window& window, BlockKind kind, WeightLine* lines) const;

  std::span<const Size> views_;
  std::vector<Patch> patches_;          // of the block, without a window so far
  std::vector<IntegerTap> patch_taps_;  // patch by patch
  std::vector<std::size_t> members_;    // the patches of one window
  PixelTaps rest_;                      // a pixel's taps without a patch or window so far
};

}  // namespace cupola
