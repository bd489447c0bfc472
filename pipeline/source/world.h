// Generated worlds: colours by direction and time, from no outside files; demo, test patterns and ground
// truth.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "pipeline/optics/vector.h"
#include "pipeline/source/direction_cells.h"

namespace cupola {

// What a world is fixed to: scenes to the horizon, patterns that test the projector to its axis.
enum class Anchor : std::uint8_t { kHorizon, kAxis };

// Something that moves over the backdrop, as it stands at one instant.
struct Sprite {
  Cone cone;         // draws nothing outside; angle 0: not there at all
  double rim = 0.0;  // radians: nearer to the axis it varies slowly, farther out fast; 0: fast throughout
  int kind = 0;      // this and the rest: the world's own
  Vec3 colour{0.0};
  Vec3 mirror{0.0};
  double scale = 0.0;
  friend bool operator==(const Sprite&, const Sprite&) = default;
};

// What a sprite does to the colour behind it: light + (1 - opacity) * behind, cut to 0..1.
struct Ink {
  Vec3 light;
  double opacity;
};

// Immutable; any thread may ask. Directions are of unit length, y up, -z front, the horizon at y = 0. Colours
// are code values from 0 to 1: they are averaged as they are.
class World {
 public:
  virtual ~World() = default;
  virtual Anchor anchor() const = 0;
  virtual Vec3 backdrop(const Vec3& d) const = 0;
  virtual int sprites() const = 0;  // drawn in rising order, the last one nearest
  virtual Sprite sprite(int index, double seconds) const = 0;
  virtual Ink ink(const Sprite& sprite, const Vec3& d) const = 0;
};

// Null when there is no such world.
std::unique_ptr<const World> make_world(std::string_view name);
std::span<const std::string_view> world_names();

// The rotation into the world's own space.
inline Mat3 world_rotation(const World& world, const Mat3& world_from_lens) {
  return world.anchor() == Anchor::kAxis ? Mat3{1.0} : world_from_lens;
}

inline Vec3 laid_over(const Ink& ink, const Vec3& behind) {
  return glm::clamp(ink.light + (1.0 - ink.opacity) * behind, 0.0, 1.0);
}

// A world at one instant: its whole colour by direction. Borrows the world.
class Instant {
 public:
  Instant(const World& world, double seconds);
  Vec3 colour(const Vec3& d) const;

 private:
  const World& world_;
  std::vector<Sprite> sprites_;
  DirectionCells cells_;
};

}  // namespace cupola
