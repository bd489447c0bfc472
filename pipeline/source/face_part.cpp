// A picture's texels against the sensor's, axis by axis. Sides are below 2^16, products below 2^32.
// SPDX-License-Identifier: MIT
#include "pipeline/source/face_part.h"

#include <cstdint>

namespace cupola {
namespace {

struct Axis {
  std::int64_t texels = 0;  // of the picture
  std::int64_t begin = 0;   // of the sensor's area
  std::int64_t extent = 0;
};

Axis across(const CameraMode& mode) {
  return {mode.width, mode.crop.x, mode.crop.width};
}
Axis down(const CameraMode& mode) {
  return {mode.height, mode.crop.y, mode.crop.height};
}

// The part's first texel in the whole; none where texels do not lie on texels, or beyond the whole.
std::optional<int> first_texel(const Axis& part, const Axis& whole) {
  if (part.texels * whole.extent != part.extent * whole.texels || whole.extent <= 0) return std::nullopt;
  const std::int64_t before = (part.begin - whole.begin) * whole.texels;
  if (before < 0 || before % (2 * whole.extent) != 0) return std::nullopt;
  const std::int64_t first = before / whole.extent;
  if (first + part.texels > whole.texels) return std::nullopt;
  return static_cast<int>(first);
}

struct Extent {
  int begin = 0;
  int length = 0;
};
Extent extent_of(int first, int last, const Axis& whole) {
  const std::int64_t begin = first * whole.extent / whole.texels;
  const std::int64_t end = (last * whole.extent + whole.texels - 1) / whole.texels;
  return {static_cast<int>(whole.begin + begin), static_cast<int>(end - begin)};
}

}  // namespace

std::optional<TexelBox> place_of(const CameraMode& part, const CameraMode& whole) {
  if (part.format != whole.format || part.bt709 != whole.bt709 || part.full_range != whole.full_range) {
    return std::nullopt;
  }
  if (whole.crop.width == 0) {
    const bool same = part.width == whole.width && part.height == whole.height;
    return same ? std::optional(TexelBox{0, 0, whole.width, whole.height}) : std::nullopt;
  }
  const auto x = first_texel(across(part), across(whole));
  const auto y = first_texel(down(part), down(whole));
  if (!x || !y) return std::nullopt;
  return TexelBox{*x, *y, *x + part.width, *y + part.height};
}

CameraArea area_of(const TexelBox& box, const CameraMode& whole) {
  const Extent x = extent_of(box.x0, box.x1, across(whole));
  const Extent y = extent_of(box.y0, box.y1, down(whole));
  return {x.begin, y.begin, x.length, y.length};
}

}  // namespace cupola
