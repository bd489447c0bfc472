// YUV faces that the tests of the YUV warp share, and what they show in RGB.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "pipeline/frame/native_image.h"
#include "tests/warp/faces.h"

namespace cupola::test {

struct YuvFaces {
  std::vector<NativeBuffer> buffers;
  std::vector<NativeImage> images;
};

// Values of a sample: (view, channel, x, y) -> 0..255, or 0..1023 where layouts have as many, x and y in the
// channel's own size.
YuvFaces make_yuv_faces(const Rig& rig, NativeLayout layout, YuvColour colour, const TexelFunction& sample);
// The same from Y, U, V by direction (0 to 255 for all layouts), one point a sample, where its middle is; to
// which Y adds noise of up to +- `noise`.
YuvFaces make_yuv_faces(const Rig& rig, NativeLayout layout, YuvColour colour,
                        const std::function<Vec3(const Vec3&)>& yuv, int noise = 0);

// R, G, B of Y, U, V, all 0 to 255, by the real matrix, not clamped. Full range ends at `white`.
Vec3 rgb_of(YuvColour colour, const Vec3& yuv, double white = 255.0);
// A sample in steps of 8 bits, with all its bits.
double value_at(const NativeImage& image, int channel, int x, int y);
void set_value(const MutableNativeImage& image, int channel, int x, int y, double value);

// What the faces show: chroma interpolated linearly, planar RGB of 16 bits, 257 a step of 8.
Faces shown(const Rig& rig, const YuvFaces& faces);

}  // namespace cupola::test
