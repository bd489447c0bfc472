// A tree grown by rule: limbs that taper, fork and bend, leaves on the twigs.
// SPDX-License-Identifier: MIT
#include "pipeline/source/tree.h"

#include <algorithm>
#include <cmath>

#include "pipeline/portable/portable_math.h"
#include "pipeline/source/noise.h"

namespace cupola {
namespace {

using portable::kPi;

constexpr int kTwig = 7;             // the level that forks no more
constexpr double kShadowCell = 0.2;  // metres

Vec3 any_direction(Dice& dice) {
  for (;;) {
    const Vec3 p{dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), dice.between(-1.0, 1.0)};
    const double square = glm::dot(p, p);
    if (square < 1.0 && square > 0.01) return p / std::sqrt(square);
  }
}

// The ray from the origin against a rounded cone.
bool hit_limb(const Limb& limb, const Vec3& d, double& distance, Vec3& normal) {
  const Vec3 axis = limb.to - limb.from;
  const Vec3 to_from = -limb.from, to_to = -limb.to;
  const double taper = limb.from_radius - limb.to_radius;
  const double m0 = glm::dot(axis, axis), m1 = glm::dot(axis, to_from), m2 = glm::dot(axis, d);
  const double m3 = glm::dot(d, to_from), m5 = glm::dot(to_from, to_from);
  const double d2 = m0 - taper * taper;
  const double k2 = d2 - m2 * m2;
  const double k1 = d2 * m3 - m1 * m2 + m2 * taper * limb.from_radius;
  const double k0 =
      d2 * m5 - m1 * m1 + 2.0 * m1 * taper * limb.from_radius - m0 * limb.from_radius * limb.from_radius;
  const double h = k1 * k1 - k0 * k2;
  if (h < 0.0) return false;
  const double side = (-std::sqrt(h) - k1) / k2;
  const double y = m1 - limb.from_radius * taper + side * m2;
  if (y > 0.0 && y < d2) {
    distance = side;
    normal = glm::normalize(d2 * (to_from + side * d) - axis * y);
    return side > 0.0;
  }
  const double m6 = glm::dot(to_to, d), m7 = glm::dot(to_to, to_to);
  const double h1 = m3 * m3 - m5 + limb.from_radius * limb.from_radius;
  const double h2 = m6 * m6 - m7 + limb.to_radius * limb.to_radius;
  const double near = h1 > 0.0 ? -m3 - std::sqrt(h1) : 1e9;
  const double far = h2 > 0.0 ? -m6 - std::sqrt(h2) : 1e9;
  distance = std::min(near, far);
  if (distance <= 0.0 || distance >= 1e9) return false;
  normal = near < far ? (to_from + near * d) / limb.from_radius : (to_to + far * d) / limb.to_radius;
  return true;
}

Cone cone_of(const Limb& limb) {
  const double from = std::sqrt(glm::dot(limb.from, limb.from)), to = std::sqrt(glm::dot(limb.to, limb.to));
  Cone cone{glm::normalize(limb.from / from + limb.to / to), 0.0};
  const auto reach = [&](const Vec3& p, double distance, double radius) {
    return std::acos(std::min(1.0, glm::dot(cone.axis, p) / distance)) + std::asin(radius / distance);
  };
  cone.angle = std::max(reach(limb.from, from, limb.from_radius), reach(limb.to, to, limb.to_radius)) + 1e-9;
  return cone;
}

}  // namespace

Tree::Tree(const Vec3& root, const Vec3& light) : light_(light) {
  across_ = glm::normalize(glm::cross(Vec3{0.0, 1.0, 0.0}, light));
  upward_ = glm::cross(light, across_);
  Dice dice(1986);
  // Roots that flare into the ground.
  for (int i = 0; i < 7; ++i) {
    const double around = 2.0 * kPi * (i + 0.3 * dice.roll()) / 7.0;
    const Vec3 out{std::cos(around), 0.0, std::sin(around)};
    limbs_.push_back(
        {root + Vec3{0.0, 0.55, 0.0} + out * 0.16, root + out * 1.0 - Vec3{0.0, 0.15, 0.0}, 0.30, 0.07});
  }
  grow(dice, root - Vec3{0.0, 0.3, 0.0}, glm::normalize(Vec3{-0.05, 1.0, 0.04}), 3.1, 0.44, 0);
  Vec3 sum{0.0};
  for (const Leaf& leaf : leaves_) sum += leaf.centre;
  crown_ = sum / static_cast<double>(leaves_.size());
  index();
}

void Tree::grow(Dice& dice, const Vec3& from, const Vec3& along, double length, double radius, int level) {
  const int pieces = level == 0 ? 5 : level < 4 ? 4 : 2;
  const double end_radius = radius * (level == 0 ? 0.74 : 0.70);
  Vec3 at = from, direction = along;
  for (int i = 0; i < pieces; ++i) {
    // Wood wanders, thin wood more, and turns up to the light.
    direction = glm::normalize(direction + any_direction(dice) * (0.05 + 0.03 * level) +
                               Vec3{0.0, 0.04 + 0.012 * level, 0.0});
    const Vec3 next = at + direction * (length / pieces);
    const auto thickness = [&](int k) { return radius + (end_radius - radius) * k / pieces; };
    limbs_.push_back({at, next, thickness(i), thickness(i + 1)});
    at = next;
    if (level >= kTwig - 2) {
      const int count = level == kTwig ? 8 : 4;
      for (int l = 0; l < count; ++l) {
        const Vec3 away = any_direction(dice);  // one roll a statement: compilers order operands as they like
        const Vec3 centre = at + away * dice.between(0.03, 0.24);
        const Vec3 normal = glm::normalize(any_direction(dice) + Vec3{0.0, 0.7, 0.0});
        leaves_.push_back({centre, normal, dice.between(0.035, 0.07), dice.roll()});
      }
    }
  }
  if (level == kTwig) return;
  const int forks = level == 0 ? 4 : dice.roll() < 0.42 ? 3 : 2;
  const Vec3 side = glm::normalize(glm::cross(direction, any_direction(dice)));
  const Vec3 other = glm::cross(direction, side);
  for (int i = 0; i < forks; ++i) {
    const double around = 2.0 * kPi * (i + dice.between(-0.18, 0.18)) / forks;
    const double spread = level == 0 ? dice.between(0.5, 0.85) : dice.between(0.32, 0.68);
    const Vec3 out = side * std::cos(around) + other * std::sin(around);
    const Vec3 heading = direction * std::cos(spread) + out * std::sin(spread);
    const double share = std::pow(1.0 / forks, 0.42) * dice.between(0.92, 1.05);
    grow(dice, at, heading, length * dice.between(0.70, 0.86), end_radius * share, level + 1);
  }
}

void Tree::index() {
  std::vector<Cone> cones;
  for (const Limb& limb : limbs_) {
    cones.push_back(cone_of(limb));
    const Vec2 from = on_shadow_plane(limb.from), along = on_shadow_plane(limb.to) - from;
    const double square = std::max(1e-12, glm::dot(along, along));
    shades_.push_back({from, along, 1.0 / square, 0.5 * (limb.from_radius + limb.to_radius),
                       glm::dot(limb.from, light_), glm::dot(limb.to - limb.from, light_), 1.0});
  }
  for (const Leaf& leaf : leaves_) {
    const double distance = std::sqrt(glm::dot(leaf.centre, leaf.centre));
    cones.push_back({leaf.centre / distance, std::asin(leaf.radius / distance) + 1e-9});
    const double facing = std::abs(glm::dot(leaf.normal, light_));
    shades_.push_back({on_shadow_plane(leaf.centre), Vec2{0.0}, 0.0, leaf.radius * std::sqrt(facing),
                       glm::dot(leaf.centre, light_), 0.0, 0.75});
  }
  cells_ = DirectionCells(cones, 160);

  constexpr double kReach = 0.05;  // metres: the widest penumbra
  Vec2 least{1e9}, most{-1e9};
  for (const Shade& shade : shades_) {
    for (const Vec2& end : {shade.from, shade.from + shade.along}) {
      least = glm::min(least, end - shade.radius - kReach);
      most = glm::max(most, end + shade.radius + kReach);
    }
  }
  shadow_corner_ = least;
  shadow_columns_ = static_cast<int>((most.x - least.x) / kShadowCell) + 1;
  shadow_rows_ = static_cast<int>((most.y - least.y) / kShadowCell) + 1;
  shadow_cells_.resize(static_cast<std::size_t>(shadow_columns_ * shadow_rows_));
  for (std::uint32_t s = 0; s < shades_.size(); ++s) {
    const Shade& shade = shades_[s];
    const Vec2 to = shade.from + shade.along;
    const Vec2 low = (glm::min(shade.from, to) - shade.radius - kReach - least) / kShadowCell;
    const Vec2 high = (glm::max(shade.from, to) + shade.radius + kReach - least) / kShadowCell;
    for (int row = static_cast<int>(low.y); row <= static_cast<int>(high.y); ++row) {
      for (int column = static_cast<int>(low.x); column <= static_cast<int>(high.x); ++column) {
        shadow_cells_[static_cast<std::size_t>(row * shadow_columns_ + column)].push_back(s);
      }
    }
  }
}

bool Tree::hit(const Vec3& d, TreeHit& hit) const {
  hit = TreeHit{};
  for (const std::uint32_t index : cells_.near(d)) {
    if (index < limbs_.size()) {
      double distance;
      Vec3 normal;
      if (hit_limb(limbs_[index], d, distance, normal) && distance < hit.distance)
        hit = {distance, normal, nullptr};
      continue;
    }
    const Leaf& leaf = leaves_[index - limbs_.size()];
    const double slope = glm::dot(d, leaf.normal);
    const double distance = glm::dot(leaf.centre, leaf.normal) / slope;
    if (!(distance > 0.0 && distance < hit.distance)) continue;
    const Vec3 off = d * distance - leaf.centre;
    if (glm::dot(off, off) > leaf.radius * leaf.radius) continue;
    hit = {distance, slope < 0.0 ? leaf.normal : -leaf.normal, &leaf};
  }
  return hit.distance < 1e9;
}

double Tree::lit(const Vec3& p, double penumbra) const {
  const Vec2 at = on_shadow_plane(p);
  const Vec2 cell = (at - shadow_corner_) / kShadowCell;
  if (!(cell.x >= 0.0 && cell.y >= 0.0 && cell.x < shadow_columns_ && cell.y < shadow_rows_)) return 1.0;
  constexpr double kClear = 0.03;  // metres: what is this near shades nothing, itself least of all
  const double depth = glm::dot(p, light_) + kClear;
  double light = 1.0;
  for (const std::uint32_t s : shadow_cells_[static_cast<std::size_t>(
           static_cast<int>(cell.y) * shadow_columns_ + static_cast<int>(cell.x))]) {
    const Shade& shade = shades_[s];
    const Vec2 off = at - shade.from;
    const double share = std::clamp(glm::dot(off, shade.along) * shade.inverse_square, 0.0, 1.0);
    if (shade.depth + share * shade.deeper < depth + 0.5 * shade.radius) continue;
    const Vec2 away = off - share * shade.along;
    const double square = glm::dot(away, away), outer = shade.radius + penumbra;
    if (square > outer * outer) continue;
    const double inside = std::min(1.0, (outer - std::sqrt(square)) / (2.0 * penumbra));
    light *= 1.0 - shade.dimming * inside;
    if (light < 0.02) return 0.0;
  }
  return light;
}

}  // namespace cupola
