// Written from the definition in docs/warp.md; shares nothing with the table builder but the optics and the
// prior's numbers.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/optimal_exact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "pipeline/warp/variogram.h"

namespace cupola {
namespace {

// A parallelogram in a view's plane: centre + a * across + b * down, a and b from -1/2 to 1/2.
struct Patch {
  Vec2 centre, across, down;
};

struct Extent {
  double width, height;
};
Extent extent_of(const Patch& p) {
  return {std::abs(p.across.x) + std::abs(p.down.x), std::abs(p.across.y) + std::abs(p.down.y)};
}

double unlikeness(const Vec2& a, const Vec2& b) {
  return std::pow(std::hypot(a.x - b.x, a.y - b.y) / kPriorScale, kPriorExponent);
}

// Five points of Gauss on each of `panels` equal parts of [low, high]: calls visit(x, share).
template <class Visit>
void integrate(double low, double high, int panels, const Visit& visit) {
  constexpr std::array<double, 5> kAt = {-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831,
                                         0.9061798459386640};
  constexpr std::array<double, 5> kShare = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                            0.4786286704993665, 0.2369268850561891};
  const double half = (high - low) / panels / 2.0;
  for (int panel = 0; panel < panels; ++panel) {
    for (int i = 0; i < 5; ++i) visit(low + (2 * panel + 1 + kAt[i]) * half, kShare[i] * half);
  }
}

// Mean unlikeness between a point and those of a texel, cut where the point has its row and column: the
// integrand has its only kink there.
double between(const Vec2& p, const Vec2& texel) {
  const double u = std::clamp(p.x, texel.x - 0.5, texel.x + 0.5);
  const double v = std::clamp(p.y, texel.y - 0.5, texel.y + 0.5);
  double sum = 0.0;
  const auto add = [&](double u0, double u1, double v0, double v1) {
    if (u1 <= u0 || v1 <= v0) return;
    integrate(v0, v1, 1, [&](double y, double share_y) {
      integrate(u0, u1, 1, [&](double x, double share_x) {
        sum += share_x * share_y * unlikeness(p, {x, y});
      });
    });
  };
  add(texel.x - 0.5, u, texel.y - 0.5, v);
  add(u, texel.x + 0.5, texel.y - 0.5, v);
  add(texel.x - 0.5, u, v, texel.y + 0.5);
  add(u, texel.x + 0.5, v, texel.y + 0.5);
  return sum;
}

// Between the points of a patch and those of a texel.
double between(const Patch& patch, const Vec2& texel) {
  const auto panels = [](const Vec2& side) { return 1 + static_cast<int>(glm::length(side)); };
  double sum = 0.0;
  integrate(-0.5, 0.5, panels(patch.down), [&](double b, double share_b) {
    integrate(-0.5, 0.5, panels(patch.across), [&](double a, double share_a) {
      sum += share_a * share_b * between(patch.centre + a * patch.across + b * patch.down, texel);
    });
  });
  return sum;
}

// Between two texels (x, y) apart: their difference is spread like a pyramid.
double between_texels(int x, int y) {
  double sum = 0.0;
  integrate(-1.0, 1.0, 4, [&](double v, double share_v) {
    integrate(-1.0, 1.0, 4, [&](double u, double share_u) {
      sum += share_u * (1.0 - std::abs(u)) * share_v * (1.0 - std::abs(v)) *
             unlikeness({x + u, y + v}, {0.0, 0.0});
    });
  });
  return sum;
}

// Gauss's elimination with row pivots.
std::vector<double> solve(std::vector<std::vector<double>> a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k; i < n; ++i) {
      if (std::abs(a[i][k]) > std::abs(a[pivot][k])) pivot = i;
    }
    std::swap(a[k], a[pivot]);
    std::swap(b[k], b[pivot]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return b;
}

// Weights of columns x rows texels from (x, y) on, row by row, for the mean over a patch.
std::vector<double> window_weights(const Patch& patch, int x, int y, int columns, int rows, double noise) {
  const auto n = static_cast<std::size_t>(columns * rows);
  std::vector<std::vector<double>> lattice(rows, std::vector<double>(columns));
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) lattice[j][i] = between_texels(i, j);
  }
  std::vector<std::vector<double>> a(n + 1, std::vector<double>(n + 1, 1.0));
  std::vector<double> b(n + 1, 1.0);
  for (std::size_t i = 0; i < n; ++i) {
    const int xi = static_cast<int>(i) % columns;
    const int yi = static_cast<int>(i) / columns;
    for (std::size_t j = 0; j < n; ++j) {
      const int xj = static_cast<int>(j) % columns;
      const int yj = static_cast<int>(j) / columns;
      a[i][j] = (i == j ? noise : 0.0) - lattice[std::abs(yi - yj)][std::abs(xi - xj)];
    }
    b[i] = -between(patch, {x + xi + 0.5, y + yi + 0.5});
  }
  a[n][n] = 0.0;
  std::vector<double> weights = solve(a, b);
  weights.pop_back();
  return weights;
}

int window_side(double extent) {
  if (extent <= 1.8) return 4;
  int side = 6;
  while (side < extent + 2.4 && side < 12) side += 2;
  return side;
}

int window_start(double centre, int side) {
  return static_cast<int>(std::floor(centre - 0.5)) - side / 2 + 1;
}

// Both singular values at least 1, by J = R(a) diag(s1, s2) R(b).
Patch at_least_a_texel(const Patch& p) {
  const double e = (p.across.x + p.down.y) / 2;
  const double f = (p.across.x - p.down.y) / 2;
  const double g = (p.across.y + p.down.x) / 2;
  const double h = (p.across.y - p.down.x) / 2;
  const double s1 = std::max(1.0, std::hypot(e, h) + std::hypot(f, g));
  const double least = std::hypot(e, h) - std::hypot(f, g);
  if (std::abs(least) >= 1.0) return p;
  const double s2 = std::copysign(1.0, least);
  const double a = (std::atan2(h, e) + std::atan2(g, f)) / 2;
  const double b = (std::atan2(h, e) - std::atan2(g, f)) / 2;
  return {p.centre,
          {std::cos(a) * s1 * std::cos(b) - std::sin(a) * s2 * std::sin(b),
           std::sin(a) * s1 * std::cos(b) + std::cos(a) * s2 * std::sin(b)},
          {-std::cos(a) * s1 * std::sin(b) - std::sin(a) * s2 * std::cos(b),
           -std::sin(a) * s1 * std::sin(b) + std::cos(a) * s2 * std::cos(b)}};
}

// How much of the texel centred at `at` a patch covers: 200 lines through it, each cut at the patch's sides.
double covered(const Patch& p, const Vec2& at) {
  const double det = p.across.x * p.down.y - p.across.y * p.down.x;
  constexpr int kLines = 200;
  double sum = 0.0;
  for (int line = 0; line < kLines; ++line) {
    const Vec2 d = Vec2{at.x - 0.5, at.y - 0.5 + (line + 0.5) / kLines} - p.centre;
    double from = 0.0;
    double to = 1.0;
    // a and b of the line's points are linear in the way t along it; each must stay within 1/2 of 0.
    const auto cut = [&](double start, double slope) {
      if (std::abs(slope) < 1e-15) {
        if (std::abs(start) > 0.5) to = from;
        return;
      }
      const double t0 = (-0.5 - start) / slope;
      const double t1 = (0.5 - start) / slope;
      from = std::max(from, std::min(t0, t1));
      to = std::min(to, std::max(t0, t1));
    };
    cut((d.x * p.down.y - d.y * p.down.x) / det, p.down.y / det);
    cut((d.y * p.across.x - d.x * p.across.y) / det, -p.across.y / det);
    sum += std::max(0.0, to - from);
  }
  return sum / kLines;
}

void normalise(std::vector<Tap>& taps, double total) {
  double sum = 0.0;
  for (const Tap& tap : taps) sum += tap.weight;
  for (Tap& tap : taps) tap.weight *= sum > 0.0 ? total / sum : 0.0;
}

// A texel of another view's plane, estimated from the texels of `view`.
std::vector<Tap> estimate(const Rig& rig, int view, const Patch& texel) {
  const Size size = rig.views[view].size;
  const Extent extent = extent_of(texel);
  std::vector<Tap> taps;
  if (std::max(extent.width, extent.height) <= 5.6 && size.width >= 4 && size.height >= 4) {
    const int columns = std::min(window_side(extent.width), size.width - size.width % 2);
    const int rows = std::min(window_side(extent.height), size.height - size.height % 2);
    const int x = std::clamp(window_start(texel.centre.x, columns), 0, size.width - columns);
    const int y = std::clamp(window_start(texel.centre.y, rows), 0, size.height - rows);
    const std::vector<double> weights = window_weights(texel, x, y, columns, rows, rig.filter.noise);
    for (int i = 0; i < columns * rows; ++i)
      taps.push_back({x + i % columns, y + i / columns, view, weights[i]});
    return taps;
  }
  const Patch raised = at_least_a_texel(texel);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double share = covered(raised, {x + 0.5, y + 0.5});
      if (share > 0.0) taps.push_back({x, y, view, share});
    }
  }
  normalise(taps, 1.0);
  return taps;
}

// Where a small step in a view's plane leads, as steps of direction: the gradients' dual vectors.
std::pair<Vec3, Vec3> steps_of_direction(const ViewSample& at, const Vec3& d) {
  const double volume = glm::dot(glm::cross(at.du, at.dv), d);
  return {glm::cross(at.dv, d) / volume, glm::cross(d, at.du) / volume};
}

std::vector<Tap> by_least_squares(const Rig& rig, int home, const Vec3& direction, const ViewSample& at,
                                  const Patch& pixel) {
  const View& plane = rig.views[home];
  const Extent extent = extent_of(pixel);
  const int columns = window_side(extent.width);
  const int rows = window_side(extent.height);
  const int x0 = window_start(pixel.centre.x, columns);
  const int y0 = window_start(pixel.centre.y, rows);
  const std::vector<double> weights = window_weights(pixel, x0, y0, columns, rows, rig.filter.noise);
  std::vector<Tap> taps;
  for (int i = 0; i < columns * rows; ++i) {
    const Vec2 uv{x0 + i % columns + 0.5, y0 + i / columns + 0.5};
    const bool inside = uv.x > 0 && uv.y > 0 && uv.x < plane.size.width && uv.y < plane.size.height;
    Vec3 d;
    ViewSample here = at;
    auto [along_u, along_v] = steps_of_direction(at, direction);
    if (inside || plane.distortion == Distortion::kNone) {
      d = direction_at(plane, uv);
      project(plane, d, here);
      std::tie(along_u, along_v) = steps_of_direction(here, d);
    } else {
      d = glm::normalize(direction + (uv.x - at.uv.x) * along_u + (uv.y - at.uv.y) * along_v);
    }
    const int own = owner(rig.views, d);
    if (own == home && inside) {
      taps.push_back({static_cast<int>(uv.x), static_cast<int>(uv.y), home, weights[i]});
    }
    if ((own == home && inside) || own < 0) continue;
    ViewSample there;
    project(rig.views[own], d, there);
    const Patch texel{there.uv,
                      {glm::dot(there.du, along_u), glm::dot(there.dv, along_u)},
                      {glm::dot(there.du, along_v), glm::dot(there.dv, along_v)}};
    for (Tap tap : estimate(rig, own, texel)) {
      tap.weight *= weights[i];
      taps.push_back(tap);
    }
  }
  return taps;
}

std::vector<Tap> by_coverage(const Rig& rig, int home, const Vec3& direction, const Patch& pixel) {
  const Patch raised = at_least_a_texel(pixel);
  const Extent extent = extent_of(raised);
  std::vector<Tap> taps;
  for (std::size_t view = 0; view < rig.views.size(); ++view) {
    const View& own = rig.views[view];
    for (int y = 0; y < own.size.height; ++y) {
      for (int x = 0; x < own.size.width; ++x) {
        const Vec3 d = direction_at(own, {x + 0.5, y + 0.5});
        ViewSample in_home;
        ViewSample in_own;
        if (glm::dot(d, direction) <= kFarthestCosine || !project(rig.views[home], d, in_home)) continue;
        const Vec2 off = glm::abs(in_home.uv - pixel.centre);
        if (off.x > extent.width / 2 + 0.51 || off.y > extent.height / 2 + 0.51) continue;
        if (owner(rig.views, d) != static_cast<int>(view)) continue;
        project(own, d, in_own);
        const double share =
            covered(raised, in_home.uv) *
            (static_cast<int>(view) == home ? 1.0 : density(in_home, d) / density(in_own, d));
        if (share > 0.0) taps.push_back({x, y, static_cast<int>(view), share});
      }
    }
  }
  return taps;
}

}  // namespace

std::vector<Tap> optimal_exact(const Rig& rig, int home, const DirectionAndSlope& looking,
                               const ViewSample& at) {
  const Patch pixel{at.uv,
                    {glm::dot(at.du, looking.d_da), glm::dot(at.dv, looking.d_da)},
                    {glm::dot(at.du, looking.d_db), glm::dot(at.dv, looking.d_db)}};
  const Extent extent = extent_of(pixel);
  const double fade = std::clamp((std::max(extent.width, extent.height) - 7.6) / 2.0, 0.0, 1.0);
  std::vector<Tap> taps;
  if (fade < 1.0) taps = by_least_squares(rig, home, looking.direction, at, pixel);
  normalise(taps, 1.0 - fade);
  if (fade > 0.0) {
    std::vector<Tap> shares = by_coverage(rig, home, looking.direction, pixel);
    normalise(shares, fade);
    taps.insert(taps.end(), shares.begin(), shares.end());
  }
  return taps;
}

}  // namespace cupola
