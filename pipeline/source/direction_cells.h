// Which of many cones a direction may lie in, found by cutting the sphere into cells.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/optics/vector.h"

namespace cupola {

// All directions within `angle` (radians, below pi / 2) of the unit direction `axis`.
struct Cone {
  Vec3 axis{0.0, 0.0, -1.0};
  double angle = 0.0;
  friend bool operator==(const Cone&, const Cone&) = default;
};

class DirectionCells {
 public:
  DirectionCells() : DirectionCells({}, 1) {}
  // A cube of 6 x side x side cells around the eye. Cones of angle 0 are in none.
  DirectionCells(std::span<const Cone> cones, int side);

  // Indices of the cones that `d` may lie in, rising; all that it does lie in are among them.
  std::span<const std::uint32_t> near(const Vec3& d) const;

 private:
  struct Run {
    std::uint32_t first, last;  // in items_
  };
  int side_;
  std::vector<Run> cells_;  // face by face, row by row
  std::vector<std::uint32_t> items_;
};

}  // namespace cupola
