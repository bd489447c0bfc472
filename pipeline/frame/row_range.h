// A run of rows of a picture: what a reader is asked for when the rest is never used.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <limits>

namespace cupola {

// Rows [first, last); by default all of them.
struct RowRange {
  int first = 0;
  int last = std::numeric_limits<int>::max();

  bool empty() const { return first >= last; }
  RowRange within(int height) const { return {std::max(first, 0), std::min(last, height)}; }
  friend bool operator==(const RowRange&, const RowRange&) = default;
};

}  // namespace cupola
