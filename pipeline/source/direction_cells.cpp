// Which of many cones a direction may lie in, found by cutting the sphere into cells.
// SPDX-License-Identifier: MIT
#include "pipeline/source/direction_cells.h"

#include <algorithm>
#include <array>
#include <cmath>

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

}  // namespace

DirectionCells::DirectionCells(std::span<const Cone> cones, int side) : side_(side) {
  constexpr double kRoundingMargin = 1e-9;
  begin_.push_back(0);
  std::vector<std::uint32_t> on_face;
  for (int face = 0; face < 6; ++face) {
    on_face.clear();
    for (std::uint32_t c = 0; c < cones.size(); ++c) {
      const double to_face =
          std::acos(std::clamp(glm::dot(on_cube(face, 0.0, 0.0), cones[c].axis), -1.0, 1.0));
      const double corner = std::acos(1.0 / std::sqrt(3.0));
      if (cones[c].angle > 0.0 && to_face < cones[c].angle + corner + kRoundingMargin) on_face.push_back(c);
    }
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column) {
        const auto edge = [side](double k) { return 2.0 * k / side - 1.0; };
        const Vec3 centre = on_cube(face, edge(column + 0.5), edge(row + 0.5));
        double reach = 0.0;
        for (const int corner : {0, 1, 2, 3}) {
          const Vec3 d = on_cube(face, edge(column + corner % 2), edge(row + corner / 2));
          reach = std::max(reach, std::acos(std::min(1.0, glm::dot(centre, d))));
        }
        for (const std::uint32_t c : on_face) {
          const double limit = cones[c].angle + reach + kRoundingMargin;
          if (glm::dot(centre, cones[c].axis) > std::cos(limit)) items_.push_back(c);
        }
        begin_.push_back(static_cast<std::uint32_t>(items_.size()));
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
  const std::size_t cell = static_cast<std::size_t>((face * side_ + row) * side_ + column);
  return {items_.data() + begin_[cell], items_.data() + begin_[cell + 1]};
}

}  // namespace cupola
