// Rigs and faces that the warp's tests share.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/optics/rig.h"

namespace cupola::test {

// Faces with their memory, in a rig's order.
struct Faces {
  std::vector<ImageBuffer> buffers;
  std::vector<Image> images;
};

// A fisheye through the C430 lens over cube faces of the given names; `diameter` is the circle's, pixels.
Rig omnimax_rig(Size frame, double diameter, Size face, const std::vector<std::string>& names);
// The production case of 1986: 1966 x 1436 from four faces.
Rig paper_rig(Size face = {1024, 1024});

// Value of a texel: (view, channel, x, y) -> 0..most.
using TexelFunction = std::function<unsigned(int view, int channel, int x, int y)>;
Faces make_faces(const Rig& rig, const TexelFunction& texel, PixelFormat format = PixelFormat::kRgbPlanar8);
// The same from a colour by direction (0 to 1 a channel), the mean of side x side points a texel.
Faces make_faces(const Rig& rig, const std::function<Vec3(const Vec3& direction)>& colour, int side = 4);

TexelFunction noise(unsigned seed, unsigned most = 255);
TexelFunction checkerboard(int side);
// The panorama in tests/golden/mars.jpg.
std::function<Vec3(const Vec3&)> photograph();

// Differences between a frame (planar) and unrounded values, three doubles a pixel, over covered pixels of
// the image.
struct Difference {
  double rms = 0.0;
  double max = 0.0;
  std::int64_t samples = 0;
  int x = 0, y = 0;  // where the largest is
};
Difference difference(const Rig& rig, const Image& frame, const std::vector<double>& exact);

// Whether two frames of one format hold the same pixels.
bool same_pixels(const Image& a, const Image& b);

}  // namespace cupola::test
