// Rigs, pixels and faces drawn at random, every one from its seed alone.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/optics/rig.h"

namespace cupola::test {

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}

  int whole(int least, int most) { return std::uniform_int_distribution<>(least, most)(engine_); }
  double real(double least, double most) { return std::uniform_real_distribution<>(least, most)(engine_); }
  double log_uniform(double least, double most);
  bool one_in(int n) { return whole(1, n) == 1; }
  Vec3 direction();
  // Any rotation.
  Mat3 pose();

 private:
  std::mt19937_64 engine_;
};

Lens random_lens(Dice& dice);
// One to six views: the cube, turned or not; overlapping or with gaps; of 1 to 179 degrees; calibrated ones
// with distortion.
std::vector<View> random_views(Dice& dice);
// Any frame model, lens, views and filter. The frame's scale is such that footprints have up to some
// thousands of texels.
Rig random_rig(Dice& dice);

// Moves the centre of a fisheye or chrome ball so that pixel (x, y) looks along `direction`, as nearly as
// doubles can; false for other models and where the frame does not reach.
bool aim(Rig& rig, const Vec3& direction, int x, int y);

struct Pixel {
  int x, y;
};
// Draws a pixel, and where the frame has a centre moves that: so that the pixel looks at a random place of a
// view, at an edge or corner of one, along the axis, at the limb, just past it, or anywhere.
Pixel random_pixel(Dice& dice, Rig& rig);

// Noise for faces of any size up to 65,535 x 65,535 in a few MiB: rows lie 61 texels apart in one block of
// memory.
class NoiseFaces {
 public:
  explicit NoiseFaces(std::uint64_t seed);
  std::vector<Image> faces(const Rig& rig) const;

 private:
  std::vector<std::uint8_t> noise_;
};

}  // namespace cupola::test
