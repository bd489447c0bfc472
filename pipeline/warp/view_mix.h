// Which views a pixel of the frame is made of, as runs of pixels that are alike.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/view_colour.h"

namespace cupola {

// A pixel is of one view, or between two by sixteenths: the two with the largest shares. Without a feather
// pixels belong to their owners, whatever their footprints reach over.
class ViewMix {
 public:
  static constexpr int kSteps = 16;

  ViewMix(const Rig& rig, WorkerPool& pool);

  std::size_t kinds() const;
  // What becomes of a sum over views a and b with shares s and 1 - s, so that what both see alike comes out
  // as each by itself would: with x = (c - offset) / gain in either, c from the sum of the x. `colours` are
  // the views'.
  ViewColour colour(std::size_t kind, std::span<const ViewColour> colours) const;

  // Calls run(first, count, kind) for the pixels [x, x + count) of row y.
  template <class Run>
  void for_each(int x, int y, int count, const Run& run) const {
    const auto row = static_cast<std::size_t>(y);
    const auto begin = runs_.begin() + static_cast<std::ptrdiff_t>(rows_[row]);
    const auto end = runs_.begin() + static_cast<std::ptrdiff_t>(rows_[row + 1]);
    auto piece = std::upper_bound(begin, end, x, [](int at, const Piece& of) { return at < of.end; });
    for (const int last = x + count; x < last; ++piece) {
      const int until = std::min<int>(last, piece->end);
      run(x, until - x, std::size_t{piece->kind});
      x = until;
    }
  }

 private:
  struct Piece {
    std::uint16_t end;  // of the row: where the next one begins
    std::uint16_t kind;
  };
  std::uint16_t kind_at(const Rig& rig, const Feather& feather, int x, int y) const;

  std::size_t views_;
  std::vector<std::size_t> rows_;  // each row's first piece, and the end of all
  std::vector<Piece> runs_;
};

}  // namespace cupola
