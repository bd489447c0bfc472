// Taps to runs, pixel by pixel.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/tap_runs.h"

namespace cupola {

void append_pixel(const std::vector<Tap>& taps, std::vector<int>& scratch, TapRuns& to) {
  to.starts.push_back(
      {static_cast<std::uint32_t>(to.runs.size()), static_cast<std::uint32_t>(to.weights.size())});
  if (taps.empty()) return;
  quantise(taps, 1 << TapRuns::kShift, 1 << TapRuns::kShift, scratch);
  bool open = false;
  for (std::size_t i = 0; i < taps.size(); ++i) {
    const Tap& tap = taps[i];
    if (scratch[i] == 0) {
      open = false;
      continue;
    }
    const bool next = open && tap.view == to.runs.back().image && tap.y == to.runs.back().y &&
                      tap.x == to.runs.back().x + to.runs.back().count;
    if (next) {
      ++to.runs.back().count;
    } else {
      to.runs.push_back({static_cast<std::uint16_t>(tap.x), static_cast<std::uint16_t>(tap.y), 1,
                         static_cast<std::uint16_t>(tap.view)});
    }
    to.weights.push_back(static_cast<std::uint16_t>(scratch[i]));
    open = true;
  }
}

void append_rows(const TapRuns& part, TapRuns& whole) {
  const auto run = static_cast<std::uint32_t>(whole.runs.size());
  const auto weight = static_cast<std::uint32_t>(whole.weights.size());
  for (const TapRuns::Start& start : part.starts) {
    whole.starts.push_back({start.run + run, start.weight + weight});
  }
  whole.runs.insert(whole.runs.end(), part.runs.begin(), part.runs.end());
  whole.weights.insert(whole.weights.end(), part.weights.begin(), part.weights.end());
}

}  // namespace cupola
