// A tree on rolling terrain under a sky: a stand-in for the paper's figure 5.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/common.hpp>

#include "pipeline/portable/portable_math.h"
#include "pipeline/source/noise.h"
#include "pipeline/source/tree.h"
#include "pipeline/source/worlds.h"

namespace cupola {
namespace {

constexpr double kFarthest = 700.0;  // metres

// Very nearly the sine: the hills need its shape only, and many times a ray.
double wave(double x) {
  const double turns = x * (0.5 / portable::kPi);
  const double t = 2.0 * (turns - std::nearbyint(turns));  // -1 to 1
  const double arch = 4.0 * t * (1.0 - std::abs(t));
  return arch * (0.775 + 0.225 * std::abs(arch));
}

// The ground's height at (x, z) relative to the eye; flat near by, hills farther off.
double terrain(double x, double z) {
  const double square = x * x + z * z;
  const double near = square / (square + 900.0), far = square / (square + 90000.0);
  return -2.1 +
         near * (1.3 * wave(0.071 * x + 0.4) * wave(0.057 * z + 2.47) +
                 2.6 * wave(0.027 * x - 0.021 * z + 2.2)) +
         far * (30.0 * wave(0.0113 * x + 1.3) * wave(0.0097 * z + 0.35) + 13.0 * wave(0.021 * x + 0.012 * z));
}

// For each azimuth how steeply the ground rises to the eye's view up to each distance, so that a ray's steps
// begin where it may first meet the ground.
class Skyline {
 public:
  Skyline() {
    std::vector<double> slopes(kAzimuths * kRings);
    for (int a = 0; a < kAzimuths; ++a) {
      const double azimuth = 2.0 * portable::kPi * a / kAzimuths;
      for (int ring = 0; ring < kRings; ++ring) {
        const double r = distance(ring);
        slopes[static_cast<std::size_t>(a * kRings + ring)] =
            terrain(r * std::sin(azimuth), -r * std::cos(azimuth)) / r;
      }
    }
    steepest_.resize(slopes.size());
    for (int a = 0; a < kAzimuths; ++a) {
      double steepest = -1e9;
      for (int ring = 0; ring < kRings; ++ring) {
        for (const int beside : {kAzimuths - 1, 0, 1}) {
          const int other = (a + beside) % kAzimuths;
          steepest = std::max(steepest, slopes[static_cast<std::size_t>(other * kRings + ring)]);
        }
        steepest_[static_cast<std::size_t>(a * kRings + ring)] = steepest + 0.001;
      }
    }
  }

  // Metres along the ground that a ray of this slope is free of it; beyond kFarthest when it never meets it.
  double free_run(const Vec3& d, double slope) const {
    const double turns = std::atan2(d.x, -d.z) * (0.5 / portable::kPi) + 1.0;
    const int azimuth = static_cast<int>(turns * kAzimuths + 0.5) % kAzimuths;
    const auto begin = steepest_.begin() + static_cast<std::ptrdiff_t>(azimuth) * kRings;
    const auto first = std::lower_bound(begin, begin + kRings, slope) - begin;
    return first == kRings ? 2.0 * kFarthest : distance(static_cast<int>(first) - 1);
  }

 private:
  static constexpr int kAzimuths = 1024;
  static constexpr int kRings = 192;
  static double distance(int ring) {
    return ring < 0 ? 0.2 : std::exp(std::log(kFarthest / 0.4) * (ring + 1) / kRings) * 0.4;
  }
  std::vector<double> steepest_;
};

class TreeWorld final : public StillWorld {
 public:
  TreeWorld() : tree_({1.2, terrain(1.2, -7.5), -7.5}, kLight) {}

  Vec3 backdrop(const Vec3& d) const override {
    TreeHit hit;
    if (tree_.hit(d, hit)) {
      const Vec3 p = d * hit.distance;
      if (p.y > terrain(p.x, p.z)) return tree_colour(d, hit);  // not a root within the ground
    }
    double distance;
    if (ground_hit(d, distance)) return ground_colour(d, distance);
    return sky(d);
  }

 private:
  static inline const Vec3 kLight = glm::normalize(Vec3{-0.66, 0.56, 0.36});
  static inline const Vec3 kSunlight{1.0, 0.93, 0.78};

  // Steps along the ray no longer than the slope allows, then closes in.
  bool ground_hit(const Vec3& d, double& distance) const {
    if (d.y > 0.2) return false;
    const double level = std::sqrt(d.x * d.x + d.z * d.z);
    const double x = d.x / level, z = d.z / level, slope = d.y / std::max(level, 1e-9);
    if (level < 0.05) {  // straight down
      distance = terrain(0.0, 0.0) / d.y;
      return true;
    }
    const auto above = [&](double r) { return slope * r - terrain(x * r, z * r); };
    double last = skyline_.free_run(d, slope), clear = above(last);
    while (last < kFarthest) {
      const double next = last + std::max(0.6 * clear, 0.012 * last);
      const double there = above(next);
      if (there < 0.0) {
        double low = last, high = next, low_gap = clear, high_gap = there;
        for (int i = 0; i < 6; ++i) {
          const double middle = low + (high - low) * std::clamp(low_gap / (low_gap - high_gap), 0.05, 0.95);
          const double gap = above(middle);
          (gap < 0.0 ? high : low) = middle;
          (gap < 0.0 ? high_gap : low_gap) = gap;
        }
        distance = 0.5 * (low + high) / level;
        return true;
      }
      last = next, clear = there;
    }
    return false;
  }

  static Vec3 sky(const Vec3& d) {
    const double up = std::max(0.0, d.y);
    Vec3 colour = glm::mix(Vec3{0.16, 0.36, 0.72}, Vec3{0.80, 0.88, 0.94}, std::exp(-3.2 * up));
    const double sun = glm::dot(d, kLight);
    colour += Vec3{0.30, 0.24, 0.14} * std::exp(14.0 * (sun - 1.0));
    // Fair-weather clouds on a plane overhead, thinning towards the horizon.
    if (up > 0.02) {
      const Vec2 p = Vec2{d.x, d.z} * (1.9 / (up + 0.16)) + Vec2{7.3, 3.1};
      double density = 0.0, weight = 0.5;
      Vec2 q = p;
      for (int octave = 0; octave < 5; ++octave) {
        density += weight * smooth_noise(q);
        q = Vec2{1.62 * q.x + 1.21 * q.y, -1.21 * q.x + 1.62 * q.y} + 11.7;
        weight *= 0.5;
      }
      const double cover = glm::smoothstep(0.47, 0.72, density) * glm::smoothstep(0.02, 0.22, up);
      const double thick = glm::smoothstep(0.58, 0.86, density);
      const Vec3 cloud = glm::mix(Vec3{1.0, 0.99, 0.97}, Vec3{0.73, 0.77, 0.84}, thick);
      colour = glm::mix(colour, cloud, 0.92 * cover);
    }
    colour = glm::mix(colour, Vec3{1.0, 0.98, 0.90}, glm::smoothstep(0.99960, 0.99975, sun));
    return glm::clamp(colour, 0.0, 1.0);
  }

  static Vec3 hazed(const Vec3& colour, double distance) {
    return glm::mix(Vec3{0.74, 0.83, 0.92}, colour, std::exp(-distance / 330.0));
  }

  Vec3 ground_colour(const Vec3& d, double distance) const {
    const Vec3 p = d * distance;
    constexpr double kStep = 0.05;
    const double here = terrain(p.x, p.z);
    const Vec3 normal =
        glm::normalize(Vec3{here - terrain(p.x + kStep, p.z), kStep, here - terrain(p.x, p.z + kStep)});
    // Meadow in patches; blades near by only, before they get finer than a texel.
    const double patches =
        smooth_noise(Vec2{p.x, p.z} * 0.09) * 0.6 + smooth_noise(Vec2{p.x, p.z} * 0.41) * 0.4;
    Vec3 colour =
        glm::mix(Vec3{0.20, 0.36, 0.10}, Vec3{0.55, 0.54, 0.21}, glm::smoothstep(0.25, 0.8, patches));
    const double detail = std::exp(-distance / 9.0);
    if (detail > 0.01) {
      const double blades =
          0.6 * smooth_noise(Vec2{p.x * 9.0, p.z * 9.0}) + 0.4 * smooth_noise(Vec2{p.x * 23.0, p.z * 23.0});
      colour *= 1.0 + 0.75 * detail * (blades - 0.5);
    }
    const double sun = std::max(0.0, glm::dot(normal, kLight)) * tree_.lit(p, 0.04);
    const Vec3 light = Vec3{0.36, 0.42, 0.52} + kSunlight * (1.25 * sun);
    return glm::clamp(hazed(colour * light, distance), 0.0, 1.0);
  }

  Vec3 tree_colour(const Vec3& d, const TreeHit& hit) const {
    const Vec3 p = d * hit.distance;
    const double facing = glm::dot(hit.normal, kLight);
    const double sun = tree_.lit(p, 0.012);
    const Vec3 out = p - tree_.crown();
    const double open = std::clamp(0.35 + 0.17 * std::sqrt(glm::dot(out, out)), 0.0, 1.0);
    const double sky_light = open * (0.75 + 0.25 * hit.normal.y);
    Vec3 colour, light;
    if (hit.leaf != nullptr) {
      const double tint = hit.leaf->tint;
      colour = tint < 0.72 ? glm::mix(Vec3{0.25, 0.42, 0.09}, Vec3{0.52, 0.58, 0.13}, tint / 0.72)
                           : glm::mix(Vec3{0.70, 0.58, 0.14}, Vec3{0.80, 0.40, 0.12}, (tint - 0.72) / 0.28);
      // Leaves let through some of what falls on their far side.
      light = Vec3{0.62, 0.66, 0.68} * sky_light +
              kSunlight * (sun * (facing > 0.0 ? 0.40 + 1.0 * facing : -0.9 * facing));
    } else {
      const double grain = smooth_noise(Vec2{13.0 * std::atan2(hit.normal.x, hit.normal.z) / 1.6, p.y * 2.2});
      colour = Vec3{0.40, 0.31, 0.24} * (0.72 + 0.5 * grain);
      light = Vec3{0.52, 0.56, 0.62} * sky_light + kSunlight * (1.15 * sun * std::max(0.0, facing));
    }
    return glm::clamp(colour * light, 0.0, 1.0);
  }

  Tree tree_;
  Skyline skyline_;
};

}  // namespace

std::unique_ptr<const World> make_tree_world() {
  return std::make_unique<TreeWorld>();
}

}  // namespace cupola
