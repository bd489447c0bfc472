// Which of many cones a direction may lie in, found by cutting the sphere into cells.
// SPDX-License-Identifier: MIT
#include "pipeline/source/direction_cells.h"

#include <algorithm>
#include <cmath>

#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

Vec3 on_cube(int face, double u, double v) {
  const double sign = face % 2 == 0 ? 1.0 : -1.0;
  switch (face / 2) {
    case 0:
      return glm::normalize(Vec3{sign, u, v});
    case 1:
      return glm::normalize(Vec3{u, sign, v});
    default:
      return glm::normalize(Vec3{u, v, sign});
  }
}

// A square of a face seen from the eye: bounds in cells of `side` to a face's edge.
Cone cone_around(int face, int side, int column, int row, int size) {
  const auto edge = [side](double k) { return 2.0 * k / side - 1.0; };
  Cone cone{on_cube(face, edge(column + 0.5 * size), edge(row + 0.5 * size)), 0.0};
  for (const int corner : {0, 1, 2, 3}) {
    const Vec3 d = on_cube(face, edge(column + size * (corner % 2)), edge(row + size * (corner / 2)));
    cone.angle = std::max(cone.angle, std::acos(std::min(1.0, glm::dot(cone.axis, d))));
  }
  return cone;
}

// Those of `among` that reach into `place`.
void pick(std::span<const Cone> cones, std::span<const std::uint32_t> among, const Cone& place,
          std::vector<std::uint32_t>& picked) {
  constexpr double kRoundingMargin = 1e-9;
  for (const std::uint32_t c : among) {
    const double limit = cones[c].angle + place.angle + kRoundingMargin;
    if (glm::dot(place.axis, cones[c].axis) > std::cos(std::min(limit, portable::kPi))) picked.push_back(c);
  }
}

}  // namespace

DirectionCells::DirectionCells(std::span<const Cone> cones, int side) : side_(side) {
  constexpr int kBlock = 8;  // cells a side, picked from together first
  cells_.resize(static_cast<std::size_t>(6 * side * side));
  std::vector<std::uint32_t> all, on_face, in_block;
  for (std::uint32_t c = 0; c < cones.size(); ++c) {
    if (cones[c].angle > 0.0) all.push_back(c);
  }
  for (int face = 0; face < 6; ++face) {
    on_face.clear();
    pick(cones, all, cone_around(face, side, 0, 0, side), on_face);
    for (int block = 0; block < side * side; ++block) {
      const int left = block % side, top = block / side;
      if (left % kBlock != 0 || top % kBlock != 0) continue;
      in_block.clear();
      pick(cones, on_face, cone_around(face, side, left, top, kBlock), in_block);
      for (int row = top; row < std::min(side, top + kBlock); ++row) {
        for (int column = left; column < std::min(side, left + kBlock); ++column) {
          Run& run = cells_[static_cast<std::size_t>((face * side + row) * side + column)];
          run.first = static_cast<std::uint32_t>(items_.size());
          pick(cones, in_block, cone_around(face, side, column, row, 1), items_);
          run.last = static_cast<std::uint32_t>(items_.size());
        }
      }
    }
  }
}

std::span<const std::uint32_t> DirectionCells::near(const Vec3& d) const {
  const Vec3 size = glm::abs(d);
  int face;
  double u, v, depth;
  if (size.x >= size.y && size.x >= size.z) {
    face = d.x > 0.0 ? 0 : 1, u = d.y, v = d.z, depth = size.x;
  } else if (size.y >= size.z) {
    face = d.y > 0.0 ? 2 : 3, u = d.x, v = d.z, depth = size.y;
  } else {
    face = d.z > 0.0 ? 4 : 5, u = d.x, v = d.y, depth = size.z;
  }
  const double scale = 0.5 * side_ / depth;
  const int column = std::min(static_cast<int>(u * scale + 0.5 * side_), side_ - 1);
  const int row = std::min(static_cast<int>(v * scale + 0.5 * side_), side_ - 1);
  const Run& run = cells_[static_cast<std::size_t>((face * side_ + row) * side_ + column)];
  return {items_.data() + run.first, items_.data() + run.last};
}

}  // namespace cupola
