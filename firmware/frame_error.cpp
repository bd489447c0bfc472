// Comparing with ewa-exact.
// SPDX-License-Identifier: MIT
#include "firmware/frame_error.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace cupola {

FrameError frame_error(const FrameMap& map, const Image& frame, const std::vector<double>& exact) {
  FrameError error;
  double squares = 0.0;
  std::int64_t count = 0;
  for (int y = 0; y < map.size.height; ++y) {
    for (int x = 0; x < map.size.width; ++x) {
      if (map.at(x, y) >= FrameMap::kUncovered) continue;
      for (int channel = 0; channel < 3; ++channel) {
        const auto at = (static_cast<std::size_t>(y) * map.size.width + x) * 3 + channel;
        const double steps =
            std::abs(frame.samples<std::uint8_t>(channel, y)[x] - std::clamp(exact[at], 0.0, 255.0));
        squares += steps * steps;
        error.max = std::max(error.max, steps);
        ++count;
      }
    }
  }
  error.rms = std::sqrt(squares / static_cast<double>(std::max<std::int64_t>(1, count)));
  return error;
}

std::vector<ImageBuffer> noise_faces(const Rig& rig) {
  std::vector<ImageBuffer> faces;
  std::mt19937 random(1);
  for (const View& view : rig.views) {
    faces.emplace_back(PixelFormat::kRgbPlanar8, view.size);
    for (int channel = 0; channel < 3; ++channel) {
      for (int y = 0; y < view.size.height; ++y) {
        std::uint8_t* row = faces.back().pixels().samples<std::uint8_t>(channel, y);
        std::generate_n(row, view.size.width, [&] { return static_cast<std::uint8_t>(random() >> 24); });
      }
    }
  }
  return faces;
}

}  // namespace cupola
