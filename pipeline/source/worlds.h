// The generated worlds by name, for world.cpp alone.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "pipeline/source/world.h"

namespace cupola {

// A world in which nothing moves.
class StillWorld : public World {
 public:
  Anchor anchor() const override { return Anchor::kHorizon; }
  int sprites() const override { return 0; }
  Sprite sprite(int, double) const override { return {}; }
  Ink ink(const Sprite&, const Vec3&) const override { return {Vec3{0.0}, 0.0}; }
};

std::unique_ptr<const World> make_demo_world();
std::unique_ptr<const World> make_tree_world();

std::unique_ptr<const World> make_grid();
std::unique_ptr<const World> make_checker();
std::unique_ptr<const World> make_fine_checker();
std::unique_ptr<const World> make_rotated_checker();
std::unique_ptr<const World> make_zone_plate();
std::unique_ptr<const World> make_white();
std::unique_ptr<const World> make_grey();
std::unique_ptr<const World> make_bars();
std::unique_ptr<const World> make_focus();
std::unique_ptr<const World> make_alignment();

}  // namespace cupola
