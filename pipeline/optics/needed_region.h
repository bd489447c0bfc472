// What a warp reads of each view, known before the first frame: sources make no more than this.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/frame/image.h"

namespace cupola {

// Texels [first, last) of one row; empty when first >= last.
struct RowSpan {
  int first = 0;
  int last = 0;
  bool empty() const { return first >= last; }
  friend bool operator==(const RowSpan&, const RowSpan&) = default;
};

struct NeededRegion {
  Size size;                  // of the whole view, texels
  std::vector<RowSpan> rows;  // one a texel row; everything outside is never used

  static NeededRegion all(Size size) {
    return {size, std::vector<RowSpan>(static_cast<std::size_t>(size.height), {0, size.width})};
  }
  static NeededRegion none(Size size) {
    return {size, std::vector<RowSpan>(static_cast<std::size_t>(size.height))};
  }

  void include(int x, int y) {
    RowSpan& row = rows[static_cast<std::size_t>(y)];
    if (row.empty()) {
      row = {x, x + 1};
    } else {
      row = {x < row.first ? x : row.first, x >= row.last ? x + 1 : row.last};
    }
  }
  void include(const NeededRegion& other) {  // of the same size
    for (int y = 0; y < size.height; ++y) {
      const RowSpan& row = other.rows[static_cast<std::size_t>(y)];
      if (row.empty()) continue;
      include(row.first, y);
      include(row.last - 1, y);
    }
  }
  std::int64_t texels() const {
    std::int64_t sum = 0;
    for (const RowSpan& row : rows) sum += row.empty() ? 0 : row.last - row.first;
    return sum;
  }
};

}  // namespace cupola
