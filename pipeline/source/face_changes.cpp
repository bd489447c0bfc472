// Row by row, 64 cells at a time, as long as any of them still looks the same.
// SPDX-License-Identifier: MIT
#include "pipeline/source/face_changes.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

namespace cupola {
namespace {

constexpr int kSide = ChangedCells::kSide;
constexpr int kGroup = 64;  // cells

// Bits of the cells, counted from `first_cell`, that hold texels of `row`.
std::uint64_t cells_of(const RowSpan& row, int first_cell) {
  if (row.empty()) return 0;
  const int from = std::clamp(row.first / kSide - first_cell, 0, kGroup);
  const int to = std::clamp((row.last + kSide - 1) / kSide - first_cell, 0, kGroup);
  return from < to ? ~std::uint64_t{0} >> (kGroup - (to - from)) << from : 0;
}

// kBytes bytes, at places that need not be aligned.
template <std::size_t kBytes>
bool differ(const std::byte* a, const std::byte* b) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < kBytes; i += 8) {
    std::uint64_t x;
    std::uint64_t y;
    std::memcpy(&x, a + i, 8);
    std::memcpy(&y, b + i, 8);
    sum |= x ^ y;
  }
  return sum != 0;
}

// The cells of one group in one row of cells, as bits.
template <std::size_t kSampleBytes>
std::uint64_t changes(const Image& before, const Image& now, const NeededRegion& needed, int first_row,
                      int first_cell) {
  const int width = now.size.width;
  const int last_row = std::min(first_row + kSide, now.size.height);
  std::uint64_t changed = 0;
  for (std::size_t plane = 0; plane < 3; ++plane) {
    for (int y = first_row; y < last_row; ++y) {
      const std::byte* old_row = before.planes[plane].row(y);
      const std::byte* new_row = now.planes[plane].row(y);
      std::uint64_t left = cells_of(needed.rows[static_cast<std::size_t>(y)], first_cell) & ~changed;
      for (; left != 0; left &= left - 1) {
        const int cell = std::countr_zero(left);
        const int x = (first_cell + cell) * kSide;
        const std::size_t at = static_cast<std::size_t>(x) * kSampleBytes;
        const bool whole = x + kSide <= width;
        const bool differs = whole ? differ<kSide * kSampleBytes>(old_row + at, new_row + at)
                                   : std::memcmp(old_row + at, new_row + at, (width - x) * kSampleBytes) != 0;
        changed |= std::uint64_t{differs} << cell;
      }
    }
  }
  return changed;
}

}  // namespace

void add_changes(const Image& before, const Image& now, const NeededRegion& needed, ChangedCells& changed) {
  const bool deep = now.format == PixelFormat::kRgbPlanar16;
  for (int y = 0; y < now.size.height; y += kSide) {
    for (int x = 0; x < now.size.width; x += kGroup * kSide) {
      std::uint64_t cells = deep ? changes<2>(before, now, needed, y, x / kSide)
                                 : changes<1>(before, now, needed, y, x / kSide);
      for (; cells != 0; cells &= cells - 1) {
        const int at = x + std::countr_zero(cells) * kSide;
        changed.add(at, y, at + 1, y + 1);
      }
    }
  }
}

}  // namespace cupola
