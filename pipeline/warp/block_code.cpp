// Patches, the windows that hold them, and the lines of weights.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/block_code.h"

#include <algorithm>

namespace cupola {
namespace {

std::uint8_t high_byte(int weight) {
  return static_cast<std::uint8_t>((weight + 64) >> 7);
}
std::uint8_t low_byte(int weight) {
  return static_cast<std::uint8_t>(weight - (((weight + 64) >> 7) << 7));
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

void start(BlockCode& code, BlockKind kind, int bits) {
  code.block = {};
  code.block.kind = kind;
  code.block.bits = static_cast<std::uint32_t>(bits);
  code.windows.clear();
  code.lines.clear();
}

void finish(BlockCode& code) {
  code.block.window_count = static_cast<std::uint32_t>(code.windows.size());
  code.block.line_count = static_cast<std::uint32_t>(code.lines.size());
}

}  // namespace

struct BlockEncoder::Placement {
  int x = 0, y = 0;
  std::size_t taken = 0;
};

// Most footprints: one view, no more than one patch. Takes it then.
bool BlockEncoder::is_one_patch(int pixel, const PixelTaps& taps) {
  const int view = taps.front().view;
  int x0 = taps.front().x;
  int y0 = taps.front().y;
  int x1 = x0;
  int y1 = y0;
  for (const IntegerTap& tap : taps) {
    if (tap.view != view) return false;
    x0 = std::min(x0, tap.x);
    y0 = std::min(y0, tap.y);
    x1 = std::max(x1, tap.x);
    y1 = std::max(y1, tap.y);
  }
  if (x1 - x0 >= kPatchWidth || y1 - y0 >= kWindowSide) return false;
  const std::size_t first = patch_taps_.size();
  patch_taps_.insert(patch_taps_.end(), taps.begin(), taps.end());
  patches_.push_back({pixel, view, x0, y0, x1 - x0 + 1, y1 - y0 + 1, first, patch_taps_.size()});
  return true;
}

// Splits a pixel's taps into patches, view by view, from the left in steps of 4 columns.
void BlockEncoder::cut_patches(int pixel, const PixelTaps& taps) {
  if (taps.empty() || is_one_patch(pixel, taps)) return;
  rest_ = taps;
  while (!rest_.empty()) {
    const int view = rest_.front().view;
    int x = views_[view].width;
    int y = views_[view].height;
    for (const IntegerTap& tap : rest_) {
      if (tap.view == view) x = std::min(x, tap.x);
    }
    for (const IntegerTap& tap : rest_) {
      if (tap.view == view && tap.x < x + kPatchWidth) y = std::min(y, tap.y);
    }
    Patch patch{pixel, view, x, y, 0, 0, patch_taps_.size(), 0};
    const auto in_patch = [&](const IntegerTap& tap) {
      return tap.view == view && tap.x >= x && tap.x < x + kPatchWidth && tap.y < y + kWindowSide;
    };
    for (const IntegerTap& tap : rest_) {
      if (!in_patch(tap)) continue;
      patch.columns = std::max(patch.columns, tap.x - x + 1);
      patch.rows = std::max(patch.rows, tap.y - y + 1);
      patch_taps_.push_back(tap);
    }
    patch.last_tap = patch_taps_.size();
    patches_.push_back(patch);
    std::erase_if(rest_, in_patch);
  }
}

// Calls visit(index) for the patches that a window at (x, y) takes, those whose columns and rows lie within:
// at most one of each pixel.
template <class Visit>
void BlockEncoder::for_each_taken(int view, int x, int y, Visit&& visit) const {
  std::uint32_t taken = 0;
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    const Patch& patch = patches_[i];
    const std::uint32_t bit = 1U << patch.pixel;
    if ((taken & bit) != 0 || patch.view != view || patch.x < x || patch.y < y ||
        patch.x + patch.columns > x + kWindowSide || patch.y + patch.rows > y + kWindowSide) {
      continue;
    }
    taken |= bit;
    visit(i);
  }
}

// The window about the first patch that takes the most.
BlockEncoder::Placement BlockEncoder::place_window() const {
  const Patch& first = patches_.front();
  const Size view = views_[first.view];
  Placement best;
  const auto try_at = [&](int x, int y) {
    Placement here{std::clamp(x, 0, view.width - kWindowSide), std::clamp(y, 0, view.height - kWindowSide),
                   0};
    for_each_taken(first.view, here.x, here.y, [&](std::size_t) { ++here.taken; });
    if (here.taken > best.taken) best = here;
    return best.taken == patches_.size();
  };
  int least_x = first.x;
  int least_y = first.y;
  for (const Patch& patch : patches_) {
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

// `lines` are the window's.
void BlockEncoder::write_weights(const Patch& patch, const Window& window, BlockKind kind,
                                 WeightLine* lines) const {
  const int start = window.start[patch.pixel];
  const int x = window.x + start % kWindowSide;
  const int y = window.y + start / kWindowSide;
  for (std::size_t t = patch.first_tap; t < patch.last_tap; ++t) {
    const IntegerTap& tap = patch_taps_[t];
    const int at = patch.pixel * kPatchWidth + tap.x - x;
    if (kind == BlockKind::kNarrow16) {
      lines[2 * (tap.y - y)].bytes[at] = high_byte(tap.weight);
      lines[2 * (tap.y - y) + 1].bytes[at] = low_byte(tap.weight);
    } else {
      std::uint8_t& weight = lines[tap.y - y].bytes[at];
      weight = static_cast<std::uint8_t>(weight + tap.weight);
    }
  }
}

void BlockEncoder::encode_narrow(const std::array<PixelTaps, kPixelsInBlock>& block, BlockKind kind, int bits,
                                 BlockCode& code) {
  start(code, kind, bits);
  patches_.clear();
  patch_taps_.clear();
  for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) cut_patches(pixel, block[pixel]);
  const int lines_a_row = kind == BlockKind::kNarrow16 ? 2 : 1;
  WeightLine no_weights;
  if (kind == BlockKind::kSigned8) no_weights.bytes.fill(kBias8);
  while (!patches_.empty()) {
    const int view = patches_.front().view;
    const Placement placed = place_window();
    Window window;
    window.x = static_cast<std::uint16_t>(placed.x);
    window.y = static_cast<std::uint16_t>(placed.y);
    window.view = static_cast<std::uint8_t>(view);
    members_.clear();
    int rows = 0;
    for_each_taken(view, placed.x, placed.y, [&](std::size_t i) {
      members_.push_back(i);
      rows = std::max(rows, patches_[i].rows);
    });
    window.rows = static_cast<std::uint8_t>(rows);
    const std::size_t first_line = code.lines.size();
    code.lines.resize(first_line + static_cast<std::size_t>(rows * lines_a_row), no_weights);
    std::uint16_t present = 0;
    for (const std::size_t i : members_) {
      const Patch& patch = patches_[i];
      const int row = std::min(patch.y - placed.y, kWindowSide - rows);
      const int column = std::min(patch.x - placed.x, kWindowSide - kPatchWidth);
      window.start[patch.pixel] = static_cast<std::uint8_t>(row * kWindowSide + column);
      present = static_cast<std::uint16_t>(present | 1 << patch.pixel);
      write_weights(patch, window, kind, &code.lines[first_line]);
    }
    finish_starts(window, present);
    code.windows.push_back(window);
    if (members_.size() == patches_.size()) break;
    for (auto i = members_.rbegin(); i != members_.rend(); ++i) {
      patches_.erase(patches_.begin() + static_cast<std::ptrdiff_t>(*i));
    }
  }
  finish(code);
}

void BlockEncoder::encode_wide(const std::array<PixelTaps, kPixelsInBlock>& block, int bits,
                               BlockCode& code) {
  start(code, BlockKind::kWide16, bits);
  for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
    rest_ = block[pixel];
    while (!rest_.empty()) {
      const int view = rest_.front().view;
      int x = views_[view].width;
      int y = views_[view].height;
      for (const IntegerTap& tap : rest_) {
        if (tap.view == view) y = std::min(y, tap.y);
      }
      y = std::min(y, views_[view].height - kWindowSide);
      for (const IntegerTap& tap : rest_) {
        if (tap.view == view && tap.y < y + kWindowSide) x = std::min(x, tap.x);
      }
      x = std::min(x, views_[view].width - kWindowSide);
      Window window;
      window.x = static_cast<std::uint16_t>(x);
      window.y = static_cast<std::uint16_t>(y);
      window.view = static_cast<std::uint8_t>(view);
      window.used = kWindowSide;
      window.start[0] = static_cast<std::uint8_t>(pixel);
      std::array<WeightLine, 2> lines;
      std::erase_if(rest_, [&](const IntegerTap& tap) {
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
  finish(code);
}

}  // namespace cupola
