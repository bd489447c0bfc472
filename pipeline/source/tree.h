// A tree grown by rule: limbs that taper, fork and bend, leaves on the twigs.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/optics/vector.h"
#include "pipeline/source/direction_cells.h"

namespace cupola {

// All within a cone rounded off by a ball at either end; metres.
struct Limb {
  Vec3 from, to;
  double from_radius, to_radius;
};

struct Leaf {  // a disc
  Vec3 centre, normal;
  double radius;
  double tint;  // 0 to 1
};

struct TreeHit {
  double distance = 1e9;
  Vec3 normal{0.0};
  const Leaf* leaf = nullptr;  // null: bark
};

// Immutable once grown; seen from the origin, lit from one direction.
class Tree {
 public:
  Tree(const Vec3& root, const Vec3& light);

  // The nearest of it along unit direction `d` from the origin; false when nothing is.
  bool hit(const Vec3& d, TreeHit& hit) const;
  // Share of the light that reaches `p`, its edges `penumbra` metres wide.
  double lit(const Vec3& p, double penumbra) const;

  const Vec3& crown() const { return crown_; }

 private:
  void grow(class Dice& dice, const Vec3& from, const Vec3& along, double length, double radius, int level);
  void index();
  Vec2 on_shadow_plane(const Vec3& p) const { return {glm::dot(p, across_), glm::dot(p, upward_)}; }

  std::vector<Limb> limbs_;
  std::vector<Leaf> leaves_;
  Vec3 crown_{0.0};
  DirectionCells cells_;  // limbs first, then leaves

  // Seen from the light: capsules on a plane across it.
  struct Shade {
    Vec2 from, along;
    double inverse_square, radius;
    double depth, deeper;  // towards the light: at `from`, and how much more at the other end
    double dimming;
  };
  Vec3 light_, across_, upward_;
  std::vector<Shade> shades_;
  Vec2 shadow_corner_{0.0};
  int shadow_columns_ = 0, shadow_rows_ = 0;
  std::vector<std::vector<std::uint32_t>> shadow_cells_;
};

}  // namespace cupola
