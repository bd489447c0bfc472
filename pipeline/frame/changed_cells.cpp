// Bits in rows of 64-bit words.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/changed_cells.h"

#include <algorithm>
#include <bit>

namespace cupola {

ChangedCells::ChangedCells(Size size)
    : size_(size),
      across_((size.width + kSide - 1) / kSide),
      down_((size.height + kSide - 1) / kSide),
      words_((across_ + 63) / 64),
      changed_(static_cast<std::size_t>(words_) * static_cast<std::size_t>(down_)) {}

void ChangedCells::clear() {
  std::fill(changed_.begin(), changed_.end(), 0);
}

void ChangedCells::add_all() {
  add(0, 0, size_.width, size_.height);
}

ChangedCells::Cells ChangedCells::cells_of(int x0, int y0, int x1, int y1) const {
  const Cells texels{std::max(x0, 0), std::max(y0, 0), std::min(x1, size_.width), std::min(y1, size_.height)};
  if (texels.empty()) return {0, 0, 0, 0};
  return {texels.x0 / kSide, texels.y0 / kSide, (texels.x1 + kSide - 1) / kSide,
          (texels.y1 + kSide - 1) / kSide};
}

std::uint64_t ChangedCells::bits(int word, int first, int last) {
  const int from = std::clamp(first - 64 * word, 0, 64);
  const int to = std::clamp(last - 64 * word, 0, 64);
  if (from >= to) return 0;
  return (~std::uint64_t{0} >> (64 - (to - from))) << from;
}

void ChangedCells::add(int x0, int y0, int x1, int y1) {
  const Cells cells = cells_of(x0, y0, x1, y1);
  if (cells.empty()) return;
  for (int y = cells.y0; y < cells.y1; ++y) {
    for (int word = cells.x0 / 64; word < words_; ++word) {
      changed_[static_cast<std::size_t>(y * words_ + word)] |= bits(word, cells.x0, cells.x1);
    }
  }
}

void ChangedCells::add(const ChangedCells& other) {
  for (std::size_t i = 0; i < changed_.size(); ++i) changed_[i] |= other.changed_[i];
}

bool ChangedCells::touches(int x0, int y0, int x1, int y1) const {
  const Cells cells = cells_of(x0, y0, x1, y1);
  if (cells.empty()) return false;
  for (int y = cells.y0; y < cells.y1; ++y) {
    for (int word = cells.x0 / 64; word <= (cells.x1 - 1) / 64; ++word) {
      if ((changed_[static_cast<std::size_t>(y * words_ + word)] & bits(word, cells.x0, cells.x1)) != 0) {
        return true;
      }
    }
  }
  return false;
}

std::int64_t ChangedCells::count() const {
  std::int64_t count = 0;
  for (const std::uint64_t word : changed_) count += std::popcount(word);
  return count;
}

}  // namespace cupola
