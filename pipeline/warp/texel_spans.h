// A set of texels of one image, of any shape: what of a pyramid's level is wanted.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "pipeline/optics/needed_region.h"

namespace cupola {

struct TexelSpans {
  // Spans closer than this become one: it costs less to make the texels between than to begin anew.
  static constexpr int kGap = 16;

  Size size;
  std::vector<std::vector<RowSpan>> rows;  // one a texel row

  static TexelSpans none(Size size) {
    return {size, std::vector<std::vector<RowSpan>>(static_cast<std::size_t>(size.height))};
  }

  // In any order, overlapping or not.
  void add(int y, RowSpan span) {
    std::vector<RowSpan>& row = rows[static_cast<std::size_t>(y)];
    if (!row.empty() && span.first >= row.back().first && span.first <= row.back().last + kGap) {
      row.back().last = std::max(row.back().last, span.last);
    } else {
      row.push_back(span);
    }
  }
  // Sorts every row's spans and joins those that touch or nearly so.
  void join() {
    for (std::vector<RowSpan>& row : rows) {
      std::sort(row.begin(), row.end(), [](const RowSpan& a, const RowSpan& b) { return a.first < b.first; });
      std::vector<RowSpan> joined;
      joined.swap(row);
      for (const RowSpan& span : joined) add(static_cast<int>(&row - rows.data()), span);
    }
  }
  std::int64_t texels() const {
    std::int64_t sum = 0;
    for (const std::vector<RowSpan>& row : rows) {
      for (const RowSpan& span : row) sum += span.last - span.first;
    }
    return sum;
  }
};

}  // namespace cupola
