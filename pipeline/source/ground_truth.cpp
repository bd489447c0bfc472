// What a perfect renderer would show: worlds averaged over the pixels of a frame, straight from their
// formulas.
// SPDX-License-Identifier: MIT
#include "pipeline/source/ground_truth.h"

#include <algorithm>
#include <cmath>

namespace cupola {

std::vector<double> render_truth_exact(const FrameGeometry& frame, const Mat3& world_from_lens,
                                       const World& world, double seconds, int samples_per_side,
                                       WorkerPool& pool) {
  const Instant instant(world, seconds);
  const Mat3 rotation = world_rotation(world, world_from_lens);
  const Size size = frame.size;
  const std::size_t plane = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  std::vector<double> truth(3 * plane, 0.0);
  pool.run(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      DirectionAndSlope seen;
      if (!ray(frame, {x + 0.5, y + 0.5}, seen)) continue;
      Vec3 sum{0.0};
      int samples = 0;
      for (int b = 0; b < samples_per_side; ++b) {
        for (int a = 0; a < samples_per_side; ++a) {
          const Vec2 p{x + (a + 0.5) / samples_per_side, y + (b + 0.5) / samples_per_side};
          if (!ray(frame, p, seen)) continue;
          sum += instant.colour(rotation * seen.direction);
          ++samples;
        }
      }
      if (samples == 0) continue;
      const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + x;
      for (int p = 0; p < 3; ++p) truth[static_cast<std::size_t>(p) * plane + at] = sum[p] * 255.0 / samples;
    }
  });
  return truth;
}

ImageBuffer render_truth(const FrameGeometry& frame, const Mat3& world_from_lens, const World& world,
                         double seconds, int samples_per_side, WorkerPool& pool) {
  const auto truth = render_truth_exact(frame, world_from_lens, world, seconds, samples_per_side, pool);
  ImageBuffer picture(PixelFormat::kRgbPlanar8, frame.size);
  auto value = truth.begin();
  for (int p = 0; p < 3; ++p) {
    for (int y = 0; y < frame.size.height; ++y) {
      auto* row = picture.pixels().samples<std::uint8_t>(p, y);
      for (int x = 0; x < frame.size.width; ++x) row[x] = static_cast<std::uint8_t>(*value++ + 0.5);
    }
  }
  return picture;
}

Vec3 mean_over(const View& view, const Vec2& corner, const Vec2& extent, const Instant& instant,
               int samples_per_side) {
  Vec3 sum{0.0};
  for (int b = 0; b < samples_per_side; ++b) {
    for (int a = 0; a < samples_per_side; ++a) {
      const Vec2 share = (Vec2{a, b} + 0.5) / static_cast<double>(samples_per_side);
      sum += instant.colour(direction_at(view, corner + extent * share));
    }
  }
  return sum / static_cast<double>(samples_per_side * samples_per_side);
}

}  // namespace cupola
