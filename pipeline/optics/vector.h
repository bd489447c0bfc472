// The vectors and matrices of the geometry, in double throughout.
// SPDX-License-Identifier: MIT
#pragma once

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace cupola {

// Right-handed eye space: x right, y up, the axis of projection is -z.
using Vec2 = glm::dvec2;
using Vec3 = glm::dvec3;
using Mat3 = glm::dmat3;  // column-major, as GLM has it

// A direction and how it moves with two picture coordinates (a: rightward, b: downward).
struct DirectionAndSlope {
  Vec3 direction;  // unit length
  Vec3 d_da;       // change of direction a unit of a
  Vec3 d_db;       // change of direction a unit of b
};

}  // namespace cupola
