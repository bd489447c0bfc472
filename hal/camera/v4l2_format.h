// Agrees with a V4L2 device on format, size, crop and rate, and says how its pictures lie in memory.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <variant>

#include "hal/camera/v4l2_node.h"

namespace cupola {

// Where a plane of the picture begins.
struct V4l2PlanePlace {
  std::size_t memory = 0;  // which of a buffer's pieces of memory
  std::size_t offset = 0;  // bytes, within it
  std::ptrdiff_t stride = 0;
  std::size_t bytes = 0;  // whole, with the last row's padding
};

struct V4l2Layout {
  CameraMode mode;
  std::size_t memories = 1;  // pieces of memory a buffer
  std::array<std::size_t, 3> memory_bytes{};
  std::array<V4l2PlanePlace, 3> planes;
};

std::variant<V4l2Layout, CameraTrouble> settle_format(const V4l2Node& node,
                                                      const CameraSetup& setup) noexcept;

}  // namespace cupola
