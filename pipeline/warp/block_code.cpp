// Patches, the windows that hold them, and the lines of weights.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/block_code.h"

#include <algorithm>

namespace cupola {
namespace {

// Taps of one pixel that fit one patch: 4 texels wide, up to 8 high.
struct Patch {
  int pixel;
  int view;
  int x, y;  // top-left texel
  int columns, rows;
  std::size_t first_tap, last_tap;  // in the block's patch taps
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
    Patch patch{pixel, view, x, y, 0, 0, patch_taps.size(), 0};
    const auto in_patch = [&](const IntegerTap& tap) {
      return tap.view == view && tap.x >= x && tap.x < x + kPatchWidth && tap.y < y + kWindowSide;
    };
    for (const IntegerTap& tap : taps) {
      if (!in_patch(tap)) continue;
      patch.columns = std::max(patch.columns, tap.x - x + 1);
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
  return patch.view == view && patch.x >= x && patch.x + patch.columns <= x + kWindowSide && patch.y >= y &&
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
    for (int dx = 0; dx <= kWindowSide - first.columns; ++dx) {
      if (try_at(first.x - dx, first.y - dy)) return best;
    }
  }
  return best;
}

// Pixels that a window has nothing for look where their neighbour looks; sets what the window uses.
void finish_starts(Window& window, std::uint16_t present) {
  for (int row = 0; row < kPixelsInBlock; row += kBlockSide) {
    int least = kWindowSide;
    int most = 0;
    std::uint8_t elsewhere = 0;
    for (int pixel = row; pixel < row + kBlockSide; ++pixel) {
      if ((present >> pixel & 1) == 0) continue;
      elsewhere = window.start[pixel];
      least = std::min(least, elsewhere / kWindowSide);
      most = std::max(most, elsewhere / kWindowSide);
    }
    for (int pixel = row; pixel < row + kBlockSide; ++pixel) {
      if ((present >> pixel & 1) == 0) window.start[pixel] = elsewhere;
    }
    window.spread = static_cast<std::uint8_t>(std::max<int>(window.spread, most - least));
    window.used = static_cast<std::uint8_t>(std::max<int>(window.used, most + window.rows));
  }
}

}  // namespace

BlockCode encode_narrow(const std::array<PixelTaps, kPixelsInBlock>& block, std::span<const Size> views,
                        BlockKind kind, int bits) {
  BlockCode code;
  code.block.kind = kind;
  code.block.bits = static_cast<std::uint32_t>(bits);
  std::vector<IntegerTap> patch_taps;
  std::vector<Patch> patches;
  for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
    PixelTaps taps = block[pixel];
    cut_patches(pixel, taps, views, patch_taps, patches);
  }
  const int lines_a_row = kind == BlockKind::kNarrow16 ? 2 : 1;
  WeightLine no_weights;
  if (kind == BlockKind::kSigned8) no_weights.bytes.fill(kBias8);
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
    code.lines.resize(first_line + static_cast<std::size_t>(rows * lines_a_row), no_weights);
    std::uint16_t present = 0;
    for (const std::size_t i : members) {
      const Patch& patch = patches[i];
      const int row = std::min(patch.y - placed.y, kWindowSide - rows);
      const int column = std::min(patch.x - placed.x, kWindowSide - kPatchWidth);
      window.start[patch.pixel] = static_cast<std::uint8_t>(row * kWindowSide + column);
      present = static_cast<std::uint16_t>(present | 1 << patch.pixel);
      for (std::size_t t = patch.first_tap; t < patch.last_tap; ++t) {
        const IntegerTap& tap = patch_taps[t];
        const int line = (tap.y - placed.y - row) * lines_a_row;
        const int at = patch.pixel * kPatchWidth + tap.x - placed.x - column;
        WeightLine* weights = &code.lines[first_line + static_cast<std::size_t>(line)];
        if (kind == BlockKind::kNarrow16) {
          weights[0].bytes[at] = high_byte(tap.weight);
          weights[1].bytes[at] = low_byte(tap.weight);
        } else {
          weights[0].bytes[at] = static_cast<std::uint8_t>(weights[0].bytes[at] + tap.weight);
        }
      }
    }
    finish_starts(window, present);
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
  code.block.kind = BlockKind::kWide16;
  code.block.bits = static_cast<std::uint32_t>(bits);
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
      window.used = kWindowSide;
      window.start[0] = static_cast<std::uint8_t>(pixel);
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

}  // namespace cupola
