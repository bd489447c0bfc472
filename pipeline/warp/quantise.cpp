// Largest remainder for heavy taps, error carried for light ones, each of four classes of texels by itself.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/quantise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

namespace cupola {
namespace {

constexpr std::size_t kFewTaps = 64;
constexpr std::size_t kHeavyTap = 4;  // steps, on average: no error to carry

// Columns and rows, even or odd: the first two are one colour of the checkerboard.
constexpr std::size_t kClasses = 4;
std::size_t class_of(const Tap& tap) {
  return static_cast<std::size_t>(2 * ((tap.x + tap.y) & 1) + (tap.x & 1));
}

using ClassSums = std::array<double, kClasses>;
using ClassTotals = std::array<int, kClasses>;

// Without the C library, which these are too many for.
int floor_of(double x) {
  const int towards_zero = static_cast<int>(x);
  return towards_zero > x ? towards_zero - 1 : towards_zero;
}
int nearest(double x) {
  return floor_of(x + 0.5);
}

// Whole numbers that sum to `total`: for the two colours nearest to their real sums, and within a colour to
// those less half of what the colour got wrong. So a colour is off by at most 1/2, a class by at most 3/4.
ClassTotals class_totals(const ClassSums& real, int total) {
  const int even = nearest(real[0] + real[1]);
  ClassTotals totals{};
  for (std::size_t first = 0; first < kClasses; first += 2) {
    const int colour = first == 0 ? even : total - even;
    totals[first] = nearest(real[first] + (colour - real[first] - real[first + 1]) / 2);
    totals[first + 1] = colour - totals[first];
  }
  return totals;
}

// In each class one more for the largest remainders, of equal ones for the first. Since a class's total is
// less than 1 from its real sum, that is never more than one a tap.
void by_largest_remainder(std::span<const Tap> taps, int total, std::vector<int>& weights) {
  std::array<double, kFewTaps> rank;  // the remainder, and 2 more a class
  ClassSums real{};
  ClassTotals whole{};
  ClassTotals count{};
  for (std::size_t i = 0; i < taps.size(); ++i) {
    const double exact = taps[i].weight * total;
    const std::size_t its = class_of(taps[i]);
    weights[i] = floor_of(exact);
    rank[i] = exact - weights[i] + static_cast<double>(2 * its);
    real[its] += exact;
    whole[its] += weights[i];
    ++count[its];
  }
  // All taps of later classes rank above a class's own.
  ClassTotals last = class_totals(real, total);
  int later = 0;
  for (std::size_t its = kClasses; its-- > 0;) {
    last[its] += later - whole[its];
    later += count[its];
  }
  for (std::size_t i = 0; i < taps.size(); ++i) {
    int before = 0;
    for (std::size_t j = 0; j < i; ++j) before += rank[j] >= rank[i] ? 1 : 0;
    for (std::size_t j = i + 1; j < taps.size(); ++j) before += rank[j] > rank[i] ? 1 : 0;
    if (before < last[class_of(taps[i])]) ++weights[i];
  }
}

// The same for more taps.
void by_sorted_remainder(std::span<const Tap> taps, int total, std::vector<int>& weights) {
  std::array<std::vector<std::pair<double, std::size_t>>, kClasses> remainders;  // less 1, and the tap
  ClassSums real{};
  ClassTotals whole{};
  for (std::size_t i = 0; i < taps.size(); ++i) {
    const double exact = taps[i].weight * total;
    weights[i] = floor_of(exact);
    const std::size_t its = class_of(taps[i]);
    remainders[its].emplace_back(weights[i] - exact, i);
    real[its] += exact;
    whole[its] += weights[i];
  }
  const ClassTotals totals = class_totals(real, total);
  for (std::size_t its = 0; its < kClasses; ++its) {
    auto& own = remainders[its];
    const int more = std::clamp(totals[its] - whole[its], 0, static_cast<int>(own.size()));
    std::nth_element(own.begin(), own.begin() + more, own.end());
    for (int i = 0; i < more; ++i) ++weights[own[static_cast<std::size_t>(i)].second];
  }
}

// A class's taps get the steps of the whole line floor(sum + phase), where the phase is the middle of those
// that end on the class's total.
void by_carrying(std::span<const Tap> taps, int total, std::vector<int>& weights) {
  ClassSums real{};
  for (const Tap& tap : taps) real[class_of(tap)] += tap.weight * total;
  const ClassTotals totals = class_totals(real, total);
  ClassSums sum{};
  for (std::size_t its = 0; its < kClasses; ++its) {
    const double off = totals[its] - real[its];
    sum[its] = (std::max(0.0, off) + std::min(1.0, 1.0 + off)) / 2;
  }
  ClassTotals given{};
  for (std::size_t i = 0; i < taps.size(); ++i) {
    const std::size_t its = class_of(taps[i]);
    sum[its] += taps[i].weight * total;
    weights[i] = floor_of(sum[its]) - given[its];
    given[its] += weights[i];
  }
}

}  // namespace

bool quantise(std::span<const Tap> taps, int total, int most, std::vector<int>& weights) {
  weights.assign(taps.size(), 0);
  if (taps.size() <= kFewTaps) {
    by_largest_remainder(taps, total, weights);
  } else if (taps.size() * kHeavyTap <= static_cast<std::size_t>(total)) {
    by_sorted_remainder(taps, total, weights);
  } else {
    by_carrying(taps, total, weights);
  }
  // Real weights sum to 1 but for rounding; what is missing or over goes to the heaviest tap.
  const auto heaviest = std::max_element(weights.begin(), weights.end());
  *heaviest += total - std::accumulate(weights.begin(), weights.end(), 0);
  if (*heaviest <= most) return true;
  // One step too many may go to the next heaviest tap; more would bend the filter.
  if (*heaviest > most + 1 || taps.size() < 2) return false;
  --*heaviest;
  std::size_t next = heaviest == weights.begin() ? 1 : 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (&weights[i] != &*heaviest && taps[i].weight > taps[next].weight) next = i;
  }
  return ++weights[next] <= most;
}

}  // namespace cupola
