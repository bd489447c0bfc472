// Largest remainder for few taps, error carried for many.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/quantise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace cupola {
namespace {

constexpr std::size_t kFewTaps = 64;

void by_largest_remainder(std::span<const Tap> taps, int total, std::vector<int>& weights) {
  std::array<double, kFewTaps> remainder;
  int left = total;
  for (std::size_t i = 0; i < taps.size(); ++i) {
    const double exact = taps[i].weight * total;
    weights[i] = static_cast<int>(exact);
    if (weights[i] > exact) --weights[i];  // the floor of it
    remainder[i] = exact - weights[i];
    left -= weights[i];
  }
  // One more for the `left` largest remainders, of equal ones for the first: those that fewer stand before.
  for (std::size_t i = 0; i < taps.size(); ++i) {
    int before = 0;
    for (std::size_t j = 0; j < i; ++j) before += remainder[j] >= remainder[i] ? 1 : 0;
    for (std::size_t j = i + 1; j < taps.size(); ++j) before += remainder[j] > remainder[i] ? 1 : 0;
    if (before < left) ++weights[i];
  }
}

void by_carrying(std::span<const Tap> taps, int total, std::vector<int>& weights) {
  double sum = 0.0;
  int given = 0;
  for (std::size_t i = 0; i < taps.size(); ++i) {
    sum += taps[i].weight * total;
    const int upto = i + 1 == taps.size() ? total : static_cast<int>(std::floor(sum + 0.5));
    weights[i] = upto - given;
    given += weights[i];
  }
}

}  // namespace

bool quantise(std::span<const Tap> taps, int total, int most, std::vector<int>& weights) {
  weights.assign(taps.size(), 0);
  if (taps.size() <= kFewTaps) {
    by_largest_remainder(taps, total, weights);
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
