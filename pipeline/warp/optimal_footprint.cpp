// Windows of least-squares weights, handed over texel by texel where another view owns them.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/optimal_footprint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "pipeline/warp/coverage.h"
#include "pipeline/warp/view_region.h"

namespace cupola {
namespace {

constexpr double kFadeFrom = 7.6;  // texels, the larger side of a pixel's box
// Estimates of single texels use windows of up to 8 x 8, which may lie wholly on one side of them.
constexpr double kMostEstimateExtent = 5.6;
// Weights below this share of the heaviest are left out: a tenth of a rounding step of the table. But not
// where they are more together than a window could have of them: a texel of a plane may be a whole stripe of
// another view.
constexpr double kFaintestShare = 3e-5;
constexpr double kMostLeftOut = LeastSquares::kMostTexels * kFaintestShare;

double extent_u(const PixelArea& area) {
  return std::abs(area.ux) + std::abs(area.uy);
}
double extent_v(const PixelArea& area) {
  return std::abs(area.vx) + std::abs(area.vy);
}

int first_texel(double centre, int side) {
  return static_cast<int>(std::floor(centre - 0.5)) - side / 2 + 1;
}

// Makes the taps from `first` on sum to `share`.
void scale(std::vector<Tap>& taps, std::size_t first, double share) {
  double sum = 0.0;
  for (std::size_t i = first; i < taps.size(); ++i) sum += taps[i].weight;
  if (!(sum > 0.0)) return;
  for (std::size_t i = first; i < taps.size(); ++i) taps[i].weight *= share / sum;
}

// Adds up taps of the same texel.
void merge(std::vector<Tap>& taps) {
  const auto place = [](const Tap& tap) { return std::tuple(tap.view, tap.y, tap.x); };
  std::stable_sort(taps.begin(), taps.end(), [&](const Tap& a, const Tap& b) { return place(a) < place(b); });
  std::size_t last = 0;
  for (std::size_t i = 1; i < taps.size(); ++i) {
    if (place(taps[i]) == place(taps[last])) {
      taps[last].weight += taps[i].weight;
    } else {
      taps[++last] = taps[i];
    }
  }
  if (!taps.empty()) taps.resize(last + 1);
}

// Changes of direction a texel of the view along u and v, at a point with gradients du and dv: du . along_u
// is 1, dv . along_u is 0 and the other way round.
struct Steps {
  Vec3 along_u, along_v;
};
Steps steps_at(const ViewSample& at, const Vec3& d) {
  const Vec3 a = glm::cross(at.dv, d);
  const Vec3 b = glm::cross(d, at.du);
  return {a / glm::dot(at.du, a), b / glm::dot(at.dv, b)};
}

// The plane of a view about one of its rays, also beyond the picture; there a lens's distortion is not known,
// and the plane of a calibrated view goes on straight from the ray.
class ViewPlane {
 public:
  ViewPlane(const View& view, const Vec3& direction, const ViewSample& at)
      : view_(view), direction_(direction), at_(at), steps_(steps_at(at, direction)) {}

  Vec3 direction(const Vec2& uv) const {
    if (knows(uv)) return direction_at(view_, uv);
    const Vec2 off = uv - at_.uv;
    return glm::normalize(direction_ + off.x * steps_.along_u + off.y * steps_.along_v);
  }
  Steps steps(const Vec2& uv, const Vec3& d) const {
    ViewSample there;
    return knows(uv) && project(view_, d, there) ? steps_at(there, d) : steps_;
  }

 private:
  bool knows(const Vec2& uv) const {
    return view_.distortion == Distortion::kNone ||
           (uv.x >= 0.0 && uv.y >= 0.0 && uv.x <= view_.size.width && uv.y <= view_.size.height);
  }
  const View& view_;
  const Vec3& direction_;
  const ViewSample& at_;
  Steps steps_;
};

}  // namespace

void OptimalFootprint::add_estimate(int view, const PixelArea& texel, double weight,
                                    std::vector<Tap>& taps) const {
  const Size size = rig_.views[static_cast<std::size_t>(view)].size;
  const auto side = [](double extent, int most) {
    return std::min(LeastSquares::side_for(extent), most / 2 * 2);
  };
  const auto place = [](double centre, int length, int most) {
    return std::clamp(first_texel(centre, length), 0, most - length);
  };
  if (std::max(extent_u(texel), extent_v(texel)) <= kMostEstimateExtent &&
      std::min(size.width, size.height) >= LeastSquares::kLeastSide) {
    TexelWindow window{0, 0, side(extent_u(texel), size.width), side(extent_v(texel), size.height)};
    window.x = place(texel.u, window.width, size.width);
    window.y = place(texel.v, window.height, size.height);
    std::array<double, LeastSquares::kMostTexels> weights;
    solver_.weigh(texel, window, weights.data());
    for (int i = 0; i < window.width * window.height; ++i) {
      taps.push_back({window.x + i % window.width, window.y + i / window.width, view, weight * weights[i]});
    }
    return;
  }
  const Coverage coverage(texel);
  const auto from = [](double centre, double half, int most) {
    return static_cast<int>(std::clamp(std::floor(centre - half), 0.0, most - 1.0));
  };
  const std::size_t first = taps.size();
  for (int y = from(texel.v, coverage.half_height(), size.height);
       y < size.height && y + 0.5 < texel.v + coverage.half_height() && taps.size() <= kMostTaps; ++y) {
    for (int x = from(texel.u, coverage.half_width(), size.width);
         x < size.width && x + 0.5 < texel.u + coverage.half_width(); ++x) {
      const double share = coverage(x + 0.5 - texel.u, y + 0.5 - texel.v);
      if (share > 0.0) taps.push_back({x, y, view, share});
    }
  }
  scale(taps, first, weight);
}

void OptimalFootprint::add_least_squares(int home, const Vec3& direction, const ViewSample& at,
                                         const PixelArea& area, std::vector<Tap>& taps) const {
  TexelWindow window{0, 0, LeastSquares::side_for(extent_u(area)), LeastSquares::side_for(extent_v(area))};
  window.x = first_texel(area.u, window.width);
  window.y = first_texel(area.v, window.height);
  std::array<double, LeastSquares::kMostTexels> weights;
  solver_.weigh(area, window, weights.data());

  const View& view = rig_.views[static_cast<std::size_t>(home)];
  const PlaneBox box{area.u, area.v, (window.width + 1) / 2.0, (window.height + 1) / 2.0};
  const bool whole = owns_whole_box(rig_.views, home, direction, box,
                                    cone_of_box(view, direction, at, box.half_width, box.half_height));
  const ViewPlane plane(view, direction, at);
  for (int i = 0; i < window.width * window.height; ++i) {
    const int x = window.x + i % window.width;
    const int y = window.y + i / window.width;
    if (whole) {
      taps.push_back({x, y, home, weights[i]});
      continue;
    }
    const Vec2 uv{x + 0.5, y + 0.5};
    const Vec3 d = plane.direction(uv);
    const int own = owner(rig_.views, d);
    // Beyond a calibrated picture the plane goes on as its model does not, and may come back into it.
    const bool stored = x >= 0 && y >= 0 && x < view.size.width && y < view.size.height;
    if (own == home && stored) {
      taps.push_back({x, y, home, weights[i]});
    } else if (own >= 0) {
      ViewSample there;
      project(rig_.views[static_cast<std::size_t>(own)], d, there);
      const Steps steps = plane.steps(uv, d);
      add_estimate(
          own,
          {there.uv.x, there.uv.y, glm::dot(there.du, steps.along_u), glm::dot(there.du, steps.along_v),
           glm::dot(there.dv, steps.along_u), glm::dot(there.dv, steps.along_v)},
          weights[i], taps);
    }
  }
  if (!whole) merge(taps);
}

void OptimalFootprint::add_coverage(int home, const Vec3& direction, const ViewSample& at,
                                    const PixelArea& area, std::vector<Tap>& taps) const {
  const Coverage coverage(area);
  const View& view = rig_.views[static_cast<std::size_t>(home)];
  const PlaneBox box{area.u, area.v, coverage.half_width(), coverage.half_height()};
  const Cone cone = cone_of_box(view, direction, at, box.half_width, box.half_height);
  if (!owns_whole_box(rig_.views, home, direction, box, cone)) {
    gather_near(rig_.views, home, direction, area.u, area.v, portable::arc_tangent2(cone.sine, cone.cosine),
                coverage, taps);
    return;
  }
  for (int y = static_cast<int>(area.v - box.half_height);
       y + 0.5 < area.v + box.half_height && taps.size() <= kMostTaps; ++y) {
    for (int x = static_cast<int>(area.u - box.half_width); x + 0.5 < area.u + box.half_width; ++x) {
      const double share = coverage(x + 0.5 - area.u, y + 0.5 - area.v);
      if (share > 0.0) taps.push_back({x, y, home, share});
    }
  }
}

void OptimalFootprint::gather(int home, const DirectionAndSlope& looking, const ViewSample& at,
                              std::vector<Tap>& taps) const {
  const PixelArea area{at.uv.x,
                       at.uv.y,
                       glm::dot(at.du, looking.d_da),
                       glm::dot(at.du, looking.d_db),
                       glm::dot(at.dv, looking.d_da),
                       glm::dot(at.dv, looking.d_db)};
  const double extent = std::max(extent_u(area), extent_v(area));
  const double fade = std::clamp((extent - kFadeFrom) / (LeastSquares::kMostExtent - kFadeFrom), 0.0, 1.0);
  if (fade < 1.0) add_least_squares(home, looking.direction, at, area, taps);
  scale(taps, 0, 1.0 - fade);
  if (fade > 0.0) {
    const std::size_t first = taps.size();
    add_coverage(home, looking.direction, at, area, taps);
    scale(taps, first, fade);
    if (taps.size() > kMostTaps) return;
    if (first > 0) merge(taps);
  }
  double heaviest = 0.0;
  for (const Tap& tap : taps) heaviest = std::max(heaviest, std::abs(tap.weight));
  const auto faint = [&](const Tap& tap) { return std::abs(tap.weight) < kFaintestShare * heaviest; };
  double left_out = 0.0;
  for (const Tap& tap : taps) left_out += faint(tap) ? std::abs(tap.weight) : 0.0;
  if (left_out <= kMostLeftOut * heaviest) std::erase_if(taps, faint);
}

}  // namespace cupola
