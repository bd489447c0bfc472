// Arithmetic of planes; odd sides have a last chroma sample of their own.
// SPDX-License-Identifier: MIT
#include "hal/camera/camera_planes.h"

namespace cupola {

int plane_count(CameraFormat format) {
  switch (format) {
    case CameraFormat::kNv12:
    case CameraFormat::kP010:
      return 2;
    case CameraFormat::kI420:
    case CameraFormat::kI422:
      return 3;
    default:
      return 1;
  }
}

PlaneShape plane_shape(CameraFormat format, int plane, int width, int height) {
  if (plane < 0 || plane >= plane_count(format)) return {};
  const std::ptrdiff_t w = width;
  const std::ptrdiff_t pairs = (w + 1) / 2;
  switch (format) {
    case CameraFormat::kYuyv:
    case CameraFormat::kUyvy:
      return {4 * pairs, height};
    case CameraFormat::kNv12:
      return plane == 0 ? PlaneShape{w, height} : PlaneShape{2 * pairs, (height + 1) / 2};
    case CameraFormat::kP010:
      return plane == 0 ? PlaneShape{2 * w, height} : PlaneShape{4 * pairs, (height + 1) / 2};
    case CameraFormat::kI420:
      return plane == 0 ? PlaneShape{w, height} : PlaneShape{pairs, (height + 1) / 2};
    case CameraFormat::kI422:
      return {plane == 0 ? w : pairs, height};
    case CameraFormat::kRgb24:
    case CameraFormat::kBgr24:
      return {3 * w, height};
    case CameraFormat::kXrgb32:
      return {4 * w, height};
    case CameraFormat::kGrey:
      return {w, height};
    case CameraFormat::kMjpeg:
      return {};
  }
  return {};
}

bool fits(const CameraFrame& frame, const CameraMode& mode) {
  if (frame.format != mode.format || frame.width != mode.width || frame.height != mode.height) return false;
  for (int p = 0; p < plane_count(frame.format); ++p) {
    const CameraPlane& plane = frame.planes[static_cast<std::size_t>(p)];
    if (!plane.data) return false;
    if (plane.stride < plane_shape(frame.format, p, frame.width, frame.height).row_bytes) return false;
  }
  return true;
}

bool is_whole(const CameraFrame& frame) {
  for (int p = 0; p < plane_count(frame.format); ++p) {
    const CameraPlane& plane = frame.planes[static_cast<std::size_t>(p)];
    const PlaneShape shape = plane_shape(frame.format, p, frame.width, frame.height);
    const std::ptrdiff_t least =
        shape.rows > 0 ? plane.stride * (shape.rows - 1) + shape.row_bytes : std::ptrdiff_t{1};
    if (plane.bytes < static_cast<std::size_t>(least)) return false;
  }
  return true;
}

}  // namespace cupola
