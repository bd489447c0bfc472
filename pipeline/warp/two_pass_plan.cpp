// The lines of the frame fitted one by one, then put together pixel by pixel.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/two_pass_plan.h"

#include <algorithm>
#include <limits>

#include "pipeline/warp/line_fitter.h"
#include "pipeline/warp/quantise.h"

namespace cupola {
namespace {

// The order is chosen from every so-manieth line.
constexpr int kLineStep = 16;

// For every view the order that loses least on a part of the frame's lines.
std::vector<PassOrder> choose_orders(const Rig& rig, WorkerPool& pool) {
  const int columns = (rig.frame.size.width + kLineStep - 1) / kLineStep;
  const int rows = (rig.frame.size.height + kLineStep - 1) / kLineStep;
  std::vector<std::array<std::array<Loss, 2>, 6>> losses(static_cast<std::size_t>(columns + rows));
  pool.run(columns + rows, [&](int task) {
    const bool column = task < columns;
    const int side = column ? rig.frame.size.width : rig.frame.size.height;
    LineFitter fitter(rig);
    fitter.gather(column, std::min(side - 1, (column ? task : task - columns) * kLineStep + kLineStep / 2));
    for (std::size_t view = 0; view < rig.views.size(); ++view) {
      for (const bool along_rows : {false, true}) {
        losses[static_cast<std::size_t>(task)][view][along_rows ? 1 : 0] = fitter.loss(view, along_rows);
      }
    }
  });
  std::vector<PassOrder> orders;
  for (std::size_t view = 0; view < rig.views.size(); ++view) {
    PassOrder best = PassOrder::kRowsForColumns;
    double least = std::numeric_limits<double>::infinity();
    for (const PassOrder order : kPassOrders) {
      Loss sum;
      for (int task = 0; task < columns + rows; ++task) {
        if ((task < columns) != serves_columns(order)) continue;
        const Loss& loss = losses[static_cast<std::size_t>(task)][view][sums_rows(order) ? 1 : 0];
        sum.energy += loss.energy;
        sum.residual += loss.residual;
      }
      const double lost = sum.energy > 0.0 ? sum.residual / sum.energy : 1.0;
      if (lost < least) {
        least = lost;
        best = order;
      }
    }
    orders.push_back(best);
  }
  return orders;
}

// Shares of every pixel in the order of their samples, to integers.
void add_second_pass(const std::vector<LineResult>& lines, const std::vector<std::uint32_t>& first_sample,
                     TwoPassPlan& plan) {
  const std::size_t pixels =
      static_cast<std::size_t>(plan.frame.width) * static_cast<std::size_t>(plan.frame.height);
  std::vector<std::uint32_t> starts(pixels + 1, 0);
  for (const LineResult& line : lines) {
    for (const Share& share : line.shares) ++starts[share.pixel + 1];
  }
  for (std::size_t i = 1; i <= pixels; ++i) starts[i] += starts[i - 1];
  std::vector<Tap> taps(starts.back());
  std::vector<std::uint32_t> next(starts.begin(), starts.end() - 1);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (const Share& share : lines[i].shares) {
      taps[next[share.pixel]++] = {static_cast<int>(first_sample[i] + share.sample), 0, 0, share.weight};
    }
  }
  std::vector<int> integers;
  std::vector<Tap> own;
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    plan.starts.push_back(
        {static_cast<std::uint32_t>(plan.runs.size()), static_cast<std::uint32_t>(plan.weights.size())});
    own.assign(taps.begin() + starts[pixel], taps.begin() + starts[pixel + 1]);
    if (own.empty()) continue;
    double sum = 0.0;
    for (const Tap& tap : own) sum += tap.weight;
    for (Tap& tap : own) tap.weight /= sum;
    quantise(own, 1 << TwoPassPlan::kShift, 1 << TwoPassPlan::kShift, integers);
    bool open = false;
    for (std::size_t k = 0; k < own.size(); ++k) {
      if (integers[k] == 0) {
        open = false;
        continue;
      }
      const auto sample = static_cast<std::uint32_t>(own[k].x);
      if (open && plan.runs.back().first + plan.runs.back().count == sample) {
        ++plan.runs.back().count;
      } else {
        plan.runs.push_back({sample, 1});
      }
      plan.weights.push_back(static_cast<std::uint16_t>(integers[k]));
      open = true;
    }
  }
  plan.starts.push_back(
      {static_cast<std::uint32_t>(plan.runs.size()), static_cast<std::uint32_t>(plan.weights.size())});
}

}  // namespace

TwoPassPlan plan_two_pass(const Rig& any_rig, WorkerPool& pool) {
  Rig rig = any_rig;
  if (rig.filter.kernel != Kernel::kGaussian) rig.filter = default_gaussian();
  TwoPassPlan plan;
  plan.frame = rig.frame.size;
  plan.orders = choose_orders(rig, pool);
  std::vector<LineResult> lines(static_cast<std::size_t>(rig.frame.size.width + rig.frame.size.height));
  pool.run(static_cast<int>(lines.size()), [&](int task) {
    const bool column = task < rig.frame.size.width;
    const bool wanted = std::any_of(plan.orders.begin(), plan.orders.end(),
                                    [&](PassOrder order) { return serves_columns(order) == column; });
    if (!wanted) return;
    LineFitter fitter(rig);
    fitter.gather(column, column ? task : task - rig.frame.size.width);
    for (std::size_t view = 0; view < rig.views.size(); ++view) {
      if (serves_columns(plan.orders[view]) == column) {
        fitter.fit(view, sums_rows(plan.orders[view]), lines[static_cast<std::size_t>(task)]);
      }
    }
  });
  std::vector<std::uint32_t> first_sample;
  for (const LineResult& line : lines) {
    first_sample.push_back(static_cast<std::uint32_t>(plan.samples.size()));
    const auto first_weight = static_cast<std::uint32_t>(plan.sample_weights.size());
    for (TwoPassPlan::Sample sample : line.samples) {
      sample.weight += first_weight;
      plan.samples.push_back(sample);
    }
    plan.sample_weights.insert(plan.sample_weights.end(), line.weights.begin(), line.weights.end());
  }
  add_second_pass(lines, first_sample, plan);
  return plan;
}

}  // namespace cupola
