// Views: cube faces, perspective pictures and calibrated cameras, from the rig's centre or beside it.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "pipeline/frame/image.h"
#include "pipeline/optics/vector.h"

namespace cupola {

enum class Distortion : std::uint8_t {
  kNone,              // a perspective picture
  kRadialTangential,  // OpenCV: k1 k2 p1 p2 k3 k4 k5 k6
  kFisheye,           // OpenCV's fisheye: k1 k2 k3 k4, angle by atan2, so that 180 degrees and more work
};

// Picture coordinates (u, v) are texels: (0, 0) is the top-left corner, v runs down, texel (i, j) has its
// centre at (i + 0.5, j + 0.5).
struct View {
  std::string name;
  Vec3 forward;  // unit and mutually orthogonal; in lens space, see Rig
  Vec3 right;
  Vec3 up;
  Size size;                 // texels; 0 x 0 until the pictures are known
  Vec2 focal{0.5, 0.5};      // as a share of width and height: 0.5 / tan(fov / 2)
  Vec2 principal{0.5, 0.5};  // as a share of width and height
  Distortion distortion = Distortion::kNone;
  std::array<double, 8> coefficients{};  // in the order given above
  double limit =
      0.0;  // kRadialTangential: largest tan(angle) before the model folds; kFisheye: largest angle
  double rec_v = 1.0;    // warp tables: rec along v in units of the filter's, for texels unequally far apart
  Vec3 position_m{0.0};  // of the eye, from the rig's centre, along the axes that the pose is in
  Vec3 shift{0.0};       // position over the distance at which seams close, see set_shifts(); 0: no parallax
};

inline bool is_shifted(const View& view) {
  return view.shift.x != 0.0 || view.shift.y != 0.0 || view.shift.z != 0.0;
}

struct ViewSample {
  Vec2 uv;
  Vec3 du;  // change of u a unit of direction; direction need not be of unit length
  Vec3 dv;
};

// The named pose of CONVENTIONS: front, left, right, top, bottom, back. False when there is no such name.
bool named_pose(std::string_view name, View& view);

// Directions are those from the rig's centre. A view from beside it sees what lies in direction d, at the
// distance at which seams close, in direction w = d - |d| shift: that is what its pose and its model are
// about.

// Where direction `d` (any length) falls in the view's plane, inside its picture or out. False where the
// model does not reach: behind a perspective view, past the limit of a calibrated one.
bool project(const View& view, const Vec3& d, Vec2& uv);
bool project(const View& view, const Vec3& d, ViewSample& sample);

// The unit direction that falls on (u, v), anywhere within the picture.
Vec3 direction_at(const View& view, const Vec2& uv);

// Texels a steradian at unit direction `d`, from the gradients of `project`: |(du x dv) . d|.
inline double density(const ViewSample& sample, const Vec3& d) {
  return std::abs(glm::dot(glm::cross(sample.du, sample.dv), d));
}

// True when `d` falls into the view's picture, its edges included.
bool covers(const View& view, const Vec3& d);

// The covering view with the largest forward cosine of `d` itself, shifted or not, the earlier one on a tie;
// -1 when none covers `d`.
int owner(std::span<const View> views, const Vec3& d);

// Texels farther than this from a pixel's ray weigh nothing, however wide the footprint: the plane in which
// it is an ellipse ends a little beyond.
inline constexpr double kFarthest = 1.5;                         // radians
inline constexpr double kFarthestCosine = 0.070737201667702910;  // of it

// Texels [x0, x1) x [y0, y1) whose centres may lie within `angle` (radians, below pi / 2) of unit direction
// `axis`: all that do, and some more.
struct TexelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
};
TexelBox texels_near(const View& view, const Vec3& axis, double angle);

}  // namespace cupola
