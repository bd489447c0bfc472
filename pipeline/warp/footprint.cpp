// Footprints: within one view in one quick scan, across seams texel by texel.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/footprint.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/portable/portable_math.h"
#include "pipeline/warp/view_region.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {

// The box is that of q < radius^2.
struct FootprintGatherer::Ellipse {
  PlaneBox box;
  double a, b, c;
  double q(double du, double dv) const { return a * du * du + b * du * dv + c * dv * dv; }
};

namespace {

// The covariance M = J J^T of the pixel in texels, both eigenvalues at least `least`, plus rec on the
// diagonal. The determinant of thin ones comes from the eigenvalues: uu vv - uv^2 loses all its digits
// where the axes differ by 10^7.
struct Covariance {
  double uu, uv, vv;
  double determinant;
};

Covariance covariance(const View& home, const ViewSample& at, const DirectionAndSlope& looking,
                      const FilterSettings& filter) {
  const double ux = glm::dot(at.du, looking.d_da);
  const double uy = glm::dot(at.du, looking.d_db);
  const double vx = glm::dot(at.dv, looking.d_da);
  const double vy = glm::dot(at.dv, looking.d_db);
  Covariance m{ux * ux + uy * uy, ux * vx + uy * vy, vx * vx + vy * vy, 0.0};
  const double least = smallest_axis(filter) * smallest_axis(filter);
  const double mean = (m.uu + m.vv) / 2;
  const double half = (m.uu - m.vv) / 2;
  const double spread = std::sqrt(half * half + m.uv * m.uv);
  const double large = mean + spread;
  const double root = ux * vy - uy * vx;
  const bool thin = mean - spread < 1e-6 * large;
  const double small = thin ? root * root / large : mean - spread;
  if (large <= least) {
    m = {least, 0.0, least, 0.0};
  } else if (small < least) {
    // M + (least - small) e e^T, where e e^T = (large I - M) / (large - small) is the smaller axis'
    // projector.
    const double lift = (least - small) / (large - small);
    m = {m.uu + lift * (large - m.uu), m.uv - lift * m.uv, m.vv + lift * (large - m.vv), 0.0};
  }
  const double rec_u = filter.rec;
  const double rec_v = filter.rec * home.rec_v;
  m.determinant =
      std::max(large, least) * std::max(small, least) + rec_u * m.vv + rec_v * m.uu + rec_u * rec_v;
  m.uu += rec_u;
  m.vv += rec_v;
  if (!thin) m.determinant = m.uu * m.vv - m.uv * m.uv;
  return m;
}

int floor_to_int(double x) {
  return static_cast<int>(std::floor(x));
}

// Makes the weights sum to 1; false and no taps where there is nothing to sum.
bool normalise(std::vector<Tap>& taps) {
  double sum = 0.0;
  double size = 0.0;
  for (const Tap& tap : taps) {
    sum += tap.weight;
    size += std::abs(tap.weight);
  }
  if (!(size > 0.0)) {
    taps.clear();
    return false;
  }
  if (sum < kLeastSignedShare * size) {
    std::erase_if(taps, [](const Tap& tap) { return tap.weight <= 0.0; });
    sum = 0.0;  // not by what was summed: negative ones may have been by far the larger part
    for (const Tap& tap : taps) sum += tap.weight;
  }
  for (Tap& tap : taps) tap.weight /= sum;
  return !taps.empty();
}

// A wider cone for less work, of a view without distortion: a step along the plane at distance 1 turns what
// the eye sees by an angle whose sine is no more than its length. From the centre an angle is at most 1 + |s|
// times as large: t^2 / (1 - s cos) with t^2 = 1 + s^2 - 2 s cos falls with cos. Sines, being concave, grow
// by no more.
Cone rough_cone_of_box(const View& home, double wide, double high) {
  const double a = wide / (home.focal.x * home.size.width);
  const double b = high / (home.focal.y * home.size.height);
  const double sine = std::min(1.0, std::sqrt(a * a + b * b) * (1.0 + glm::length(home.shift)) + 1e-7);
  return {sine, std::sqrt((1.0 - sine) * (1.0 + sine))};
}

}  // namespace

void FootprintGatherer::gather_inside(int view, const Ellipse& ellipse, std::vector<Tap>& taps) const {
  const double limit = rig_.filter.radius * rig_.filter.radius;
  const PlaneBox& box = ellipse.box;
  // Centres u + 0.5 within the box.
  const int x0 = floor_to_int(box.u - box.half_width + 0.5);
  const int x1 = floor_to_int(box.u + box.half_width - 0.5);
  const int y0 = floor_to_int(box.v - box.half_height + 0.5);
  const int y1 = floor_to_int(box.v + box.half_height - 0.5);
  for (int y = y0; y <= y1 && taps.size() <= kMostTaps; ++y) {
    const double dv = y + 0.5 - box.v;
    for (int x = x0; x <= x1; ++x) {
      const double q = ellipse.q(x + 0.5 - box.u, dv);
      if (q < limit) taps.push_back({x, y, view, kernel_(q)});
    }
  }
}

FootprintGatherer::FootprintGatherer(const Rig& rig) : rig_(rig), kernel_(rig.filter), feather_(rig.seams) {
  if (rig.filter.kernel == Kernel::kOptimal) optimal_ = std::make_unique<OptimalFootprint>(rig);
  if (!(rig.seams.feather_deg > 0.0)) return;
  for (const View& view : rig.views) {
    auto alone = std::make_unique<Rig>(rig);
    alone->views = {view};
    alone->seams = {};
    alone_.push_back(std::make_unique<FootprintGatherer>(*alone));
    alone_rigs_.push_back(std::move(alone));
  }
}

Footprint FootprintGatherer::gather(int x, int y, std::vector<Tap>& taps) const {
  taps.clear();
  DirectionAndSlope looking;
  if (!ray(rig_.frame, {x + 0.5, y + 0.5}, looking)) return Footprint::kOutside;
  std::array<double, kMostViews> shares{};
  if (!feather_.shares(rig_.views, looking.direction, shares)) return gather_home(looking, taps);
  gather_feathered(looking, shares, taps);
  return normalise(taps) ? Footprint::kCovered : Footprint::kUncovered;
}

void FootprintGatherer::gather_feathered(const DirectionAndSlope& looking, std::span<const double> shares,
                                         std::vector<Tap>& taps) const {
  std::vector<Tap> own;
  for (std::size_t view = 0; view < alone_.size(); ++view) {
    if (shares[view] == 0.0) continue;
    own.clear();
    if (alone_[view]->gather_home(looking, own) != Footprint::kCovered) continue;
    for (const Tap& tap : own)
      taps.push_back({tap.x, tap.y, static_cast<int>(view), shares[view] * tap.weight});
  }
}

Footprint FootprintGatherer::gather_home(const DirectionAndSlope& looking, std::vector<Tap>& taps) const {
  const int home = owner(rig_.views, looking.direction);
  ViewSample at;
  if (home < 0 || !project(rig_.views[static_cast<std::size_t>(home)], looking.direction, at)) {
    return Footprint::kUncovered;
  }
  if (optimal_) {
    optimal_->gather(home, looking, at, taps);
  } else {
    gather_ellipse(home, looking, at, taps);
  }
  if (taps.size() > kMostTaps) return Footprint::kCovered;
  return normalise(taps) ? Footprint::kCovered : Footprint::kUncovered;
}

void FootprintGatherer::gather_ellipse(int home, const DirectionAndSlope& looking, const ViewSample& at,
                                       std::vector<Tap>& taps) const {
  const Covariance m = covariance(rig_.views[static_cast<std::size_t>(home)], at, looking, rig_.filter);
  const double f = m.determinant;
  const double radius = rig_.filter.radius;
  const Ellipse ellipse{{at.uv.x, at.uv.y, radius * std::sqrt(m.uu), radius * std::sqrt(m.vv)},
                        m.vv / f,
                        -2.0 * m.uv / f,
                        m.uu / f};
  const PlaneBox& box = ellipse.box;
  const View& view = rig_.views[static_cast<std::size_t>(home)];
  const Cone rough = rough_cone_of_box(view, box.half_width, box.half_height);
  const bool well_inside =
      view.distortion == Distortion::kNone && owns_whole_box(rig_.views, home, looking.direction, box, rough);
  const Cone cone =
      well_inside ? rough : cone_of_box(view, looking.direction, at, box.half_width, box.half_height);
  if (well_inside || owns_whole_box(rig_.views, home, looking.direction, box, cone)) {
    gather_inside(home, ellipse, taps);
    return;
  }
  const auto weight = [&](double du, double dv) {
    const double q = ellipse.q(du, dv);
    return q < radius * radius ? kernel_(q) : 0.0;
  };
  gather_near(rig_.views, home, looking.direction, box.u, box.v,
              portable::arc_tangent2(cone.sine, cone.cosine), weight, taps);
}

}  // namespace cupola
