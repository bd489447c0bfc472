// Where a rigid thing is, and which way it is turned.
// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "pipeline/optics/view.h"

namespace cupola {

// Takes points of the thing to points of what it is in: turn * x + place, metres.
struct Pose {
  Mat3 turn{1.0};
  Vec3 place{0.0};

  Vec3 operator()(const Vec3& x) const { return turn * x + place; }
  Pose operator*(const Pose& inner) const { return {turn * inner.turn, turn * inner.place + place}; }
};

inline Pose inverse(const Pose& pose) {
  const Mat3 back = glm::transpose(pose.turn);
  return {back, -(back * pose.place)};
}

// A turn by |w| radians about w.
inline Mat3 turn_about(const Vec3& w) {
  const double angle = glm::length(w);
  const double y = angle * angle;
  const double s = angle < 1e-5 ? 1.0 - y / 6.0 : std::sin(angle) / angle;
  const double c = angle < 1e-5 ? 0.5 - y / 24.0 : (1.0 - std::cos(angle)) / y;
  const Mat3 cross{Vec3{0, w.z, -w.y}, Vec3{-w.z, 0, w.x}, Vec3{w.y, -w.x, 0}};
  return Mat3{1.0} + s * cross + c * cross * cross;
}

// Radians between two turns.
inline double angle_between(const Mat3& a, const Mat3& b) {
  const Mat3 d = glm::transpose(a) * b;
  const Vec3 axis{d[1][2] - d[2][1], d[2][0] - d[0][2], d[0][1] - d[1][0]};
  return std::atan2(glm::length(axis), d[0][0] + d[1][1] + d[2][2] - 1.0);
}

// A camera's axes as OpenCV has them, x right, y down, z forward, are a view's right, -up, forward.
inline Mat3 camera_axes(const View& view) {
  return {view.right, -view.up, view.forward};
}
inline void set_axes(View& view, const Mat3& turn) {
  view.forward = glm::normalize(turn[2]);
  view.right = glm::normalize(turn[0] - view.forward * glm::dot(turn[0], view.forward));
  view.up = glm::cross(view.right, view.forward);
}

}  // namespace cupola
