// Generated worlds: the list of them, and a world's colour at one instant.
// SPDX-License-Identifier: MIT
#include "pipeline/source/world.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/source/worlds.h"

namespace cupola {
namespace {

constexpr std::array<std::string_view, 12> kNames = {
    "demo",       "tree",  "grid", "checker", "fine-checker", "rotated-checker",
    "zone-plate", "white", "grey", "bars",    "focus",        "alignment"};
using Make = std::unique_ptr<const World> (*)();
constexpr std::array<Make, kNames.size()> kMakers = {
    make_demo_world, make_tree_world, make_grid, make_checker, make_fine_checker, make_rotated_checker,
    make_zone_plate, make_white,      make_grey, make_bars,    make_focus,        make_alignment};

std::vector<Cone> cones_of(std::span<const Sprite> sprites) {
  std::vector<Cone> cones;
  for (const Sprite& sprite : sprites) cones.push_back(sprite.cone);
  return cones;
}

std::vector<Sprite> sprites_at(const World& world, double seconds) {
  std::vector<Sprite> sprites;
  for (int i = 0; i < world.sprites(); ++i) sprites.push_back(world.sprite(i, seconds));
  return sprites;
}

}  // namespace

std::unique_ptr<const World> make_world(std::string_view name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  return found == kNames.end() ? nullptr : kMakers[static_cast<std::size_t>(found - kNames.begin())]();
}

std::span<const std::string_view> world_names() {
  return kNames;
}

Instant::Instant(const World& world, double seconds)
    : world_(world), sprites_(sprites_at(world, seconds)), cells_(cones_of(sprites_), 32) {}

Vec3 Instant::colour(const Vec3& d) const {
  Vec3 colour = world_.backdrop(d);
  for (const std::uint32_t index : cells_.near(d)) {
    const Sprite& sprite = sprites_[index];
    if (glm::dot(d, sprite.cone.axis) < std::cos(sprite.cone.angle)) continue;
    colour = laid_over(world_.ink(sprite, d), colour);
  }
  return colour;
}

}  // namespace cupola
