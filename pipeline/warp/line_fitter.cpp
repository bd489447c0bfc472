// Weights sorted by line of texels, line by line a matrix, and its best product.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/line_fitter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/warp/quantise.h"

namespace cupola {
namespace {

// One sample cannot serve pixels whose weights in the line differ too much, above all where the frame's line
// turns back or runs along the texels': they are parted in two until no pixel loses more than this share of
// its energy, the sum of its weights' squares, in any line.
constexpr double kMostLost = 1.0 / 512.0;
// Shares below this over the square root of a pixel's texels, about its number of lines, are left out, and
// weights of a sample below this of its largest.
constexpr double kLeastShare = 1.0 / 1024.0;
constexpr double kLeastWeight = 1.0 / 1024.0;

}  // namespace

void LineFitter::gather(bool column, int line) {
  column_ = column;
  line_ = line;
  footprints_.clear();
  pixels_of_line_.clear();
  const int length = column ? rig_.frame.size.height : rig_.frame.size.width;
  std::vector<Tap> taps;
  for (int p = 0; p < length; ++p) {
    gatherer_.gather(column ? line : p, column ? p : line, taps);
    Footing footing;
    footing.least_share = kLeastShare / std::sqrt(static_cast<double>(std::max<std::size_t>(1, taps.size())));
    for (const Tap& tap : taps) {
      footprints_.push_back({tap, p});
      footing.energy += tap.weight * tap.weight;
    }
    pixels_of_line_.push_back(footing);
  }
}

// Entries of one view sorted by line; within a line they stay in the order of pixels.
template <class Body>
void LineFitter::for_each_line(std::size_t view, bool along_rows, const Body& body) {
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
                                          along_rows ? each.tap.x : each.tap.y, each.pixel, each.tap.weight};
  }
  for (std::size_t i = 0; i + 1 < starts_.size(); ++i) {
    if (starts_[i] == starts_[i + 1]) continue;
    body(std::span<const Entry>(sorted_.data() + starts_[i], starts_[i + 1] - starts_[i]));
  }
}

// Pixels that look at the line become the matrix' rows, without those between that do not.
const DenseMatrix& LineFitter::matrix(std::span<const Entry> line) {
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

Loss LineFitter::loss(std::size_t view, bool along_rows) {
  Loss sum;
  for_each_line(view, along_rows, [&](std::span<const Entry> line) {
    const DenseMatrix& w = matrix(line);
    fit_rank_one(w, 0, w.rows, fit_);
    sum.energy += fit_.energy;
    sum.residual += fit_.residual;
  });
  return sum;
}

void LineFitter::fit(std::size_t view, bool along_rows, LineResult& result) {
  for_each_line(view, along_rows, [&](std::span<const Entry> line) {
    const DenseMatrix& w = matrix(line);
    fit_part(w, 0, w.rows, view, along_rows, result);
  });
}

void LineFitter::fit_part(const DenseMatrix& w, std::size_t first, std::size_t last, std::size_t view,
                          bool along_rows, LineResult& result) {
  fit_rank_one(w, first, last, fit_);
  bool parted = false;
  for (std::size_t p = first; p < last; ++p) {
    parted |= fit_.lost[p - first] > kMostLost * pixels_of_line_[static_cast<std::size_t>(pixels_[p])].energy;
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
    if (share < pixels_of_line_[static_cast<std::size_t>(pixels_[p])].least_share) continue;
    const int x = column_ ? line_ : pixels_[p];
    const int y = column_ ? pixels_[p] : line_;
    const auto pixel = static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(rig_.frame.size.width) +
                       static_cast<std::uint32_t>(x);
    result.shares.push_back({pixel, static_cast<std::uint32_t>(result.samples.size()), share});
    used = true;
  }
  if (used) add_sample(view, along_rows, result);
}

void LineFitter::add_sample(std::size_t view, bool along_rows, LineResult& result) {
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

}  // namespace cupola
