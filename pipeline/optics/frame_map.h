// Which view feeds each pixel of a frame (the paper's figure 4).
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"

namespace cupola {

struct FrameMap {
  static constexpr std::uint8_t kUncovered = 254;  // in the image, but no view covers it: black
  static constexpr std::uint8_t kOutside = 255;    // not in the image

  Size size;
  std::vector<std::uint8_t> owner;  // row by row: the view's index, kUncovered or kOutside
  std::array<std::int64_t, 6> pixels_of_view{};
  std::int64_t in_image = 0;  // the uncovered ones included
  std::int64_t uncovered = 0;

  std::uint8_t at(int x, int y) const { return owner[static_cast<std::size_t>(y) * size.width + x]; }
};

FrameMap map_frame(const Rig& rig, WorkerPool& pool);

}  // namespace cupola
