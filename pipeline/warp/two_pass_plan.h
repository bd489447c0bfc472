// EWA taken apart into two passes of one-dimensional filters, fitted by least squares.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"

namespace cupola {

// The first pass sums along a view's rows or columns; its samples serve the pixels of one column or row of
// the frame. The order is a view's own, since side faces stand across.
enum class PassOrder : std::uint8_t { kRowsForColumns, kRowsForRows, kColumnsForColumns, kColumnsForRows };
inline constexpr std::array<PassOrder, 4> kPassOrders = {PassOrder::kRowsForColumns, PassOrder::kRowsForRows,
                                                         PassOrder::kColumnsForColumns,
                                                         PassOrder::kColumnsForRows};

inline bool sums_rows(PassOrder order) {
  return order == PassOrder::kRowsForColumns || order == PassOrder::kRowsForRows;
}
inline bool serves_columns(PassOrder order) {
  return order == PassOrder::kRowsForColumns || order == PassOrder::kColumnsForColumns;
}

// Weights of either pass are 1 and more and sum to exactly 2^14.
struct TwoPassPlan {
  static constexpr int kShift = 14;
  struct Sample {  // first pass: texels in a line
    std::uint16_t x, y;
    std::uint16_t count;
    std::uint8_t view;
    bool along_row;
    std::uint32_t weight;  // index of the first
  };
  struct Run {  // second pass: samples one after another
    std::uint32_t first;
    std::uint32_t count;
  };
  struct Start {
    std::uint32_t run, weight;
  };

  Size frame;
  std::vector<PassOrder> orders;  // one a view
  std::vector<Sample> samples;
  std::vector<std::uint16_t> sample_weights;
  std::vector<Start> starts;  // one a pixel, row by row, and one for the end
  std::vector<Run> runs;
  std::vector<std::uint16_t> weights;
};

// With the default Gaussian in place of a kernel with lobes.
TwoPassPlan plan_two_pass(const Rig& rig, WorkerPool& pool);

}  // namespace cupola
