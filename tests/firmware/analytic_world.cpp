// Spots are compared by their centroids, the rest sample by sample.
// SPDX-License-Identifier: MIT
#include "tests/firmware/analytic_world.h"

#include <algorithm>
#include <cmath>

#include "pipeline/optics/frame_geometry.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

double sky(const Vec3& d, int channel) {
  return 110.0 + 40.0 * std::sin(2.0 * d.x + channel) * std::cos(1.7 * d.y) +
         20.0 * std::sin(2.3 * d.z + 1.0);
}
double spot(const Vec3& off) {
  return 70.0 * std::exp(-glm::dot(off, off) / (2.0 * 0.018 * 0.018));
}

}  // namespace

std::vector<Vec3> marks() {
  std::vector<Vec3> places;
  for (int i = 0; i < 97; ++i) {
    const double z = -1.0 + (i + 0.5) / 97.0;
    const double r = std::sqrt(1.0 - z * z);
    places.emplace_back(r * std::cos(2.399963 * i), r * std::sin(2.399963 * i), z);
  }
  return places;
}

Vec3 world(const Vec3& d, const std::vector<Vec3>& places) {
  double marked = 0.0;
  for (const Vec3& place : places) {
    const Vec3 off = d - place;
    if (std::abs(off.x) < 0.1 && std::abs(off.y) < 0.1 && std::abs(off.z) < 0.1) marked += spot(off);
  }
  return {sky(d, 0) + marked, sky(d, 1) + marked, sky(d, 2) + marked};
}

DomeError dome_error(const ImageBuffer& frame, const Rig& rig) {
  const std::vector<Vec3> places = marks();
  std::vector<Vec3> rays(kDomeSide * kDomeSide, Vec3{0.0});
  for (int y = 0; y < kDomeSide; ++y) {
    for (int x = 0; x < kDomeSide; ++x) {
      DirectionAndSlope looking;
      if (ray(rig.frame, {x + 0.5, y + 0.5}, looking) && owner(rig.views, looking.direction) >= 0)
        rays[static_cast<std::size_t>(y * kDomeSide + x)] = looking.direction;
    }
  }
  // Whether all around (x, y) is seen.
  const auto inside = [&](int x, int y, int reach) {
    for (int j = -reach; j <= reach; ++j) {
      for (int i = -reach; i <= reach; ++i) {
        if (x + i < 0 || y + j < 0 || x + i >= kDomeSide || y + j >= kDomeSide) return false;
        if (rays[static_cast<std::size_t>((y + j) * kDomeSide + x + i)] == Vec3{0.0}) return false;
      }
    }
    return true;
  };
  DomeError error;
  double squares = 0.0;
  const auto note = [&](double off) {
    error.smooth = std::max(error.smooth, off);
    squares += off * off;
  };
  for (int y = 0; y < kDomeSide; ++y) {
    for (int x = 0; x < kDomeSide; ++x) {
      if (!inside(x, y, 2)) continue;
      const Vec3& d = rays[static_cast<std::size_t>(y * kDomeSide + x)];
      if (std::any_of(places.begin(), places.end(),
                      [&](const Vec3& place) { return glm::length(d - place) < 0.11; }))
        continue;
      ++error.pixels;
      for (int c = 0; c < 3; ++c) note(std::abs(sample(frame, c, x, y) - sky(d, c)));
    }
  }
  error.rms = std::sqrt(squares / (3.0 * error.pixels));
  for (const Vec3& place : places) {
    // The pixel that is nearest to it.
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (glm::dot(rays[i], place) > glm::dot(rays[nearest], place)) nearest = i;
    }
    const int x0 = static_cast<int>(nearest) % kDomeSide;
    const int y0 = static_cast<int>(nearest) / kDomeSide;
    constexpr int kReach = 8;
    if (!inside(x0, y0, kReach)) continue;
    Vec2 there{0.0};
    Vec2 here{0.0};
    double weight_there = 0.0;
    double weight_here = 0.0;
    for (int y = y0 - kReach; y <= y0 + kReach; ++y) {
      for (int x = x0 - kReach; x <= x0 + kReach; ++x) {
        const Vec3& d = rays[static_cast<std::size_t>(y * kDomeSide + x)];
        const double truth = spot(d - place);
        const double shown = sample(frame, 1, x, y) - sky(d, 1);
        if (truth < 0.5 && shown < 3.0) continue;
        there += truth * Vec2{x, y};
        weight_there += truth;
        here += shown * Vec2{x, y};
        weight_here += shown;
      }
    }
    error.mark = std::max(error.mark, glm::length(here / weight_here - there / weight_there));
    ++error.marks;
  }
  return error;
}

}  // namespace cupola
