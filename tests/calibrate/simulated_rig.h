// Cameras that are not what the rig file says, and what they see of a printed board.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/calibrate/board.h"
#include "pipeline/calibrate/pose.h"
#include "pipeline/calibrate/sighting.h"
#include "pipeline/frame/image.h"

namespace cupola {

struct SimulatedCamera {
  View view;  // as it is, in the rig's axes
  Vec3 place{0.0};
};

// front, left, right and top, 120 degrees wide, with lenses, poses and places that are a little wrong;
// front's pose is exact. `nominal` are the same as a rig file would have them.
std::vector<SimulatedCamera> simulated_cameras(Size size);
std::vector<View> nominal_views(Size size);

struct SimulatedShot {
  Pose board;                // rig from board
  std::vector<int> cameras;  // that take a picture of it
};

// `own` shots a camera all over its picture, and `common` ones at each seam between front and another and
// between top and its neighbours. The board is tilted one way and another.
std::vector<SimulatedShot> simulated_shots(const std::vector<SimulatedCamera>& cameras, const Board& board,
                                           int own, int common);

// Where the corners fall; none when one of them is not in the picture, 8 texels from its edges.
std::optional<Sighting> exact_sighting(const SimulatedCamera& camera, const Board& board, const Pose& pose);
// All of them, with normal noise of `noise` texels a coordinate.
std::vector<Sighting> noisy_sightings(const std::vector<SimulatedCamera>& cameras,
                                      const std::vector<SimulatedShot>& shots, const Board& board,
                                      double noise);

// Takes pictures: every texel the mean of 3 x 3 rays, in double precision.
class Photographer {
 public:
  explicit Photographer(const SimulatedCamera& camera);
  // Grey, with normal noise of `noise` steps of 255. kRgb8.
  ImageBuffer take(const Board& board, const Pose& pose, double noise, std::uint32_t seed) const;
  // Of a world far away: its colour by direction, 0 to 255.
  template <class World>
  ImageBuffer take(World&& world) const;

  static constexpr int kRays = 3;  // a side of a texel

 private:
  SimulatedCamera camera_;
  std::vector<Vec3> rays_;  // texel by texel
};

// Normally distributed, the same on every machine.
class SimulatedNoise {
 public:
  explicit SimulatedNoise(std::uint32_t seed) : state_(seed * 2654435761U + 1U) {}
  double next();

 private:
  double even();
  std::uint64_t state_;
};

template <class World>
ImageBuffer Photographer::take(World&& world) const {
  const Size size = camera_.view.size;
  ImageBuffer picture(PixelFormat::kRgb8, size);
  std::size_t ray = 0;
  for (int y = 0; y < size.height; ++y) {
    auto* row = picture.pixels().samples<std::uint8_t>(0, y);
    for (int x = 0; x < size.width; ++x) {
      Vec3 sum{0.0};
      for (int i = 0; i < kRays * kRays; ++i) sum += world(rays_[ray++]);
      sum /= kRays * kRays;
      for (int c = 0; c < 3; ++c)
        row[3 * x + c] = static_cast<std::uint8_t>(std::clamp(sum[c] + 0.5, 0.0, 255.0));
    }
  }
  return picture;
}

}  // namespace cupola
