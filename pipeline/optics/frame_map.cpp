// Finds the owner of every pixel, a row a task.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/frame_map.h"

namespace cupola {

FrameMap map_frame(const Rig& rig, WorkerPool& pool) {
  FrameMap map;
  map.size = rig.frame.size;
  const auto width = static_cast<std::size_t>(map.size.width);
  map.owner.assign(width * static_cast<std::size_t>(map.size.height), FrameMap::kOutside);
  pool.run(map.size.height, [&](int y) {
    std::uint8_t* row = map.owner.data() + static_cast<std::size_t>(y) * width;
    for (int x = 0; x < map.size.width; ++x) {
      DirectionAndSlope looking;
      if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking)) continue;
      const int view = owner(rig.views, looking.direction);
      row[x] = view < 0 ? FrameMap::kUncovered : static_cast<std::uint8_t>(view);
    }
  });
  for (const std::uint8_t owner : map.owner) {
    if (owner == FrameMap::kOutside) continue;
    ++map.in_image;
    if (owner == FrameMap::kUncovered) {
      ++map.uncovered;
    } else {
      ++map.pixels_of_view[owner];
    }
  }
  return map;
}

}  // namespace cupola
