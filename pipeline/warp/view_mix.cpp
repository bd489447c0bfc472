// Kinds: the views, then every pair of them by sixteenths.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/view_mix.h"

#include <array>
#include <cmath>

#include "pipeline/warp/warp_table.h"

namespace cupola {
namespace {

constexpr std::size_t kBetween = ViewMix::kSteps - 1;

// Of the pairs (0, 1), (0, 2), ... (1, 2), ... of `views` the place of (a, b), a < b.
std::size_t place_of(std::size_t a, std::size_t b, std::size_t views) {
  return a * views - a * (a + 1) / 2 + b - a - 1;
}

}  // namespace

ViewMix::ViewMix(const Rig& rig, WorkerPool& pool) : views_(rig.views.size()) {
  const Size size = rig.frame.size;
  const Feather feather(rig.seams);
  std::vector<std::vector<Piece>> rows(static_cast<std::size_t>(size.height));
  pool.run(size.height, [&](int y) {
    std::vector<Piece>& row = rows[static_cast<std::size_t>(y)];
    for (int x = 0; x < size.width; ++x) {
      const std::uint16_t kind = kind_at(rig, feather, x, y);
      if (row.empty() || row.back().kind != kind) row.push_back({0, kind});
      row.back().end = static_cast<std::uint16_t>(x + 1);
    }
  });
  for (const std::vector<Piece>& row : rows) {
    rows_.push_back(runs_.size());
    runs_.insert(runs_.end(), row.begin(), row.end());
  }
  rows_.push_back(runs_.size());
}

std::uint16_t ViewMix::kind_at(const Rig& rig, const Feather& feather, int x, int y) const {
  DirectionAndSlope looking;
  if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking)) return 0;
  std::array<double, kMostViews> shares{};
  if (!feather.shares(rig.views, looking.direction, shares))
    return static_cast<std::uint16_t>(std::max(0, owner(rig.views, looking.direction)));
  std::size_t most = 0;
  for (std::size_t v = 1; v < views_; ++v) most = shares[v] > shares[most] ? v : most;
  std::size_t next = most == 0 ? 1 : 0;
  for (std::size_t v = 0; v < views_; ++v) next = v != most && shares[v] > shares[next] ? v : next;
  const std::size_t a = std::min(most, next);
  const std::size_t b = std::max(most, next);
  const auto of_a = static_cast<std::size_t>(std::lround(kSteps * shares[a] / (shares[a] + shares[b])));
  if (of_a == 0) return static_cast<std::uint16_t>(b);
  if (of_a == kSteps) return static_cast<std::uint16_t>(a);
  return static_cast<std::uint16_t>(views_ + place_of(a, b, views_) * kBetween + of_a - 1);
}

std::size_t ViewMix::kinds() const {
  return views_ + views_ * (views_ - 1) / 2 * kBetween;
}

ViewColour ViewMix::colour(std::size_t kind, std::span<const ViewColour> colours) const {
  if (kind < views_) return colours[kind];
  const std::size_t pair = (kind - views_) / kBetween;
  const double share = static_cast<double>((kind - views_) % kBetween + 1) / kSteps;
  std::size_t a = 0;
  while (place_of(a, views_ - 1, views_) < pair) ++a;
  const std::size_t b = a + 1 + pair - place_of(a, a + 1, views_);
  ViewColour mixed;
  for (std::size_t c = 0; c < 3; ++c) {
    const double of_a = share / colours[a].gain[c];
    const double of_b = (1.0 - share) / colours[b].gain[c];
    mixed.gain[c] = 1.0 / (of_a + of_b);
    mixed.offset[c] = mixed.gain[c] * (of_a * colours[a].offset[c] + of_b * colours[b].offset[c]);
  }
  return mixed;
}

}  // namespace cupola
