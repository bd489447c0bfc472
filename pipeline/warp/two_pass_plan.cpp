// For one line of the frame and one line of a view, the weights that pixels p give to texels u are a matrix
// w(p, u). Two passes make it a product b(p) a(u): a is one sample of the first pass, b its share in the
// pixels. Lines of texels have nothing in common, so the best such products line by line are the best whole.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/two_pass_plan.h"

#include <algorithm>
#include <limits>

#include "pipeline/warp/footprint.h"
#include "pipeline/warp/quantise.h"
#include "pipeline/warp/rank_one.h"

namespace cupola {
namespace {

// One sample cannot serve pixels whose weights in the line differ too much, above all where the frame's line
// turns back or runs along the texels': they are parted in two until no pixel loses more than this share of
// its energy, the sum of its weights' squares, in any line.
constexpr double kMostLost = 1.0 / 512.0;
// Shares of a pixel and weights of a sample below these are left out.
constexpr double kLeastShare = 1.0 / 2048.0;
constexpr double kLeastWeight = 1.0 / 1024.0;
// The order is chosen from every so-manieth line.
constexpr int kLineStep = 16;

// One weight: of texel `along` in a line of a view for pixel `pixel` of the frame's line.
struct Entry {
  std::int32_t line, along, pixel;
  double weight;
};

struct Share {
  std::uint32_t pixel;   // of the frame
  std::uint32_t sample;  // of the line, then of the plan
  double weight;
};

// All that one line of the frame adds.
struct LineResult {
  std::vector<TwoPassPlan::Sample> samples;
  std::vector<std::uint16_t> weights;
  std::vector<Share> shares;
};

struct Loss {
  double energy = 0.0, residual = 0.0;
};

class LineFitter {
 public:
  explicit LineFitter(const Rig& rig) : rig_(rig), gatherer_(rig) {}

  // The footprints of a column or row of the frame.
  void gather(bool column, int line) {
    column_ = column;
    line_ = line;
    footprints_.clear();
    energies_.clear();
    const int length = column ? rig_.frame.size.height : rig_.frame.size.width;
    std::vector<Tap> taps;
    for (int p = 0; p < length; ++p) {
      gatherer_.gather(column ? line : p, column ? p : line, taps);
      energies_.push_back(0.0);
      for (const Tap& tap : taps) {
        footprints_.push_back({tap, p});
        energies_.back() += tap.weight * tap.weight;
      }
    }
  }

  // What one sample a line of texels would lose, without parting.
  Loss loss(std::size_t view, bool along_rows) {
    Loss sum;
    for_each_line(view, along_rows, [&](std::span<const Entry> line) {
      const DenseMatrix& w = matrix(line);
      fit_rank_one(w, 0, w.rows, fit_);
      sum.energy += fit_.energy;
      sum.residual += fit_.residual;
    });
    return sum;
  }

  void fit(std::size_t view, bool along_rows, LineResult& result) {
    for_each_line(view, along_rows, [&](std::span<const Entry> line) {
      const DenseMatrix& w = matrix(line);
      fit_part(w, 0, w.rows, view, along_rows, result);
    });
  }

 private:
  struct Footed {
    Tap tap;
    std::int32_t pixel;
  };

  // Entries of one view sorted by line; within a line they stay in the order of pixels.
  template <class Body>
  void for_each_line(std::size_t view, bool along_rows, const Body& body) {
    const Size size = rig_.views[view].size;
    starts_.assign(static_cast<std::size_t>(along_rows ? size.height : size.width) + 1, 0);
    std::size_t count = 0;
    const auto line_of = [&](const Tap& tap) { return static_cast<std::size_t>(along_rows ? tap.y : tap.x); };
    for (const Footed& each : footprints_) {
      if (each.tap.view != static_cast<int>(view)) continue;
      ++starts_[line_of(each.tap) + 1];
      ++count;
    }
    for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    sorted_.resize(count);
    std::vector<std::uint32_t> next = starts_;
    for (const Footed& each : footprints_) {
      if (each.tap.view != static_cast<int>(view)) continue;
      sorted_[next[line_of(each.tap)]++] = {along_rows ? each.tap.y : each.tap.x,
                                            along_rows ? each.tap.x : each.tap.y, each.pixel,
                                            each.tap.weight};
    }
    for (std::size_t i = 0; i + 1 < starts_.size(); ++i) {
      if (starts_[i] == starts_[i + 1]) continue;
      body(std::span<const Entry>(sorted_.data() + starts_[i], starts_[i + 1] - starts_[i]));
    }
  }

  // Pixels that look at the line become the matrix' rows, without those between that do not.
  const DenseMatrix& matrix(std::span<const Entry> line) {
    int least = std::numeric_limits<int>::max();
    int most = 0;
    pixels_.clear();
    for (const Entry& e : line) {
      least = std::min(least, e.along);
      most = std::max(most, e.along);
      if (pixels_.empty() || pixels_.back() != e.pixel) pixels_.push_back(e.pixel);
    }
    first_along_ = least;
    texel_line_ = line.front().line;
    matrix_.rows = pixels_.size();
    matrix_.columns = static_cast<std::size_t>(most - least) + 1;
    matrix_.entries.assign(matrix_.rows * matrix_.columns, 0.0);
    std::size_t row = 0;
    for (const Entry& e : line) {
      if (pixels_[row] != e.pixel) ++row;
      matrix_.entries[row * matrix_.columns + static_cast<std::size_t>(e.along - least)] = e.weight;
    }
    return matrix_;
  }

  void fit_part(const DenseMatrix& w, std::size_t first, std::size_t last, std::size_t view, bool along_rows,
                LineResult& result) {
    fit_rank_one(w, first, last, fit_);
    bool parted = false;
    for (std::size_t p = first; p < last; ++p) {
      parted |= fit_.lost[p - first] > kMostLost * energies_[static_cast<std::size_t>(pixels_[p])];
    }
    if (parted && last - first > 1) {
      const std::size_t middle = first + (last - first) / 2;
      fit_part(w, first, middle, view, along_rows, result);
      fit_part(w, middle, last, view, along_rows, result);
      return;
    }
    bool used = false;
    for (std::size_t p = first; p < last; ++p) {
      const double share = fit_.b[p - first];
      if (share < kLeastShare) continue;
      const int x = column_ ? line_ : pixels_[p];
      const int y = column_ ? pixels_[p] : line_;
      const auto pixel = static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(rig_.frame.size.width) +
                         static_cast<std::uint32_t>(x);
      result.shares.push_back({pixel, static_cast<std::uint32_t>(result.samples.size()), share});
      used = true;
    }
    if (used) add_sample(view, along_rows, result);
  }

  void add_sample(std::size_t view, bool along_rows, LineResult& result) {
    const double most = *std::max_element(fit_.a.begin(), fit_.a.end());
    std::size_t first = 0;
    std::size_t last = fit_.a.size();
    while (fit_.a[first] < kLeastWeight * most) ++first;
    while (fit_.a[last - 1] < kLeastWeight * most) --last;
    taps_.clear();
    double sum = 0.0;
    for (std::size_t i = first; i < last; ++i) {
      taps_.push_back({static_cast<int>(i), 0, 0, fit_.a[i]});
      sum += fit_.a[i];
    }
    for (Tap& tap : taps_) tap.weight /= sum;
    quantise(taps_, 1 << TwoPassPlan::kShift, 1 << TwoPassPlan::kShift, integers_);
    const int along = first_along_ + static_cast<int>(first);
    result.samples.push_back({static_cast<std::uint16_t>(along_rows ? along : texel_line_),
                              static_cast<std::uint16_t>(along_rows ? texel_line_ : along),
                              static_cast<std::uint16_t>(last - first), static_cast<std::uint8_t>(view),
                              along_rows, static_cast<std::uint32_t>(result.weights.size())});
    for (const int weight : integers_) result.weights.push_back(static_cast<std::uint16_t>(weight));
  }

  const Rig& rig_;
  FootprintGatherer gatherer_;
  bool column_ = false;
  int line_ = 0;
  std::vector<Footed> footprints_;
  std::vector<double> energies_;  // of each pixel, the sum of its weights' squares
  std::vector<std::uint32_t> starts_;
  std::vector<Entry> sorted_;
  std::vector<std::int32_t> pixels_;
  DenseMatrix matrix_;
  int first_along_ = 0;
  int texel_line_ = 0;
  RankOne fit_;
  std::vector<Tap> taps_;
  std::vector<int> integers_;
};

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

TwoPassPlan plan_two_pass(const Rig& rig, WorkerPool& pool) {
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
