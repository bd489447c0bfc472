// Making YUV faces, and the reference's way from them to RGB.
// SPDX-License-Identifier: MIT
#include "tests/warp/yuv_faces.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace cupola::test {
namespace {

Size channel_size(const NativeImage& image, int channel) {
  return channel == 0 ? image.size : chroma_size(image.layout, image.size);
}

double interpolated(const NativeImage& face, int channel, int x, int y) {
  const Size size = channel_size(face, channel);
  const double u = (x + 0.5) / 2.0 - 0.5;
  const double v = has_chroma_in_every_row(face.layout) ? y : (y + 0.5) / 2.0 - 0.5;
  const int u0 = static_cast<int>(std::floor(u));
  const int v0 = static_cast<int>(std::floor(v));
  const auto at = [&](int i, int j) {
    return value_at(face, channel, std::clamp(i, 0, size.width - 1), std::clamp(j, 0, size.height - 1));
  };
  return std::lerp(std::lerp(at(u0, v0), at(u0 + 1, v0), u - u0),
                   std::lerp(at(u0, v0 + 1), at(u0 + 1, v0 + 1), u - u0), v - v0);
}

// Of the words of P010, its samples' unused bits included.
double words(NativeLayout layout) {
  return sample_bytes(layout) == 2 ? 256.0 : 1.0;
}
double steps(NativeLayout layout) {
  return sample_bytes(layout) == 2 ? 4.0 : 1.0;
}

}  // namespace

double value_at(const NativeImage& image, int channel, int x, int y) {
  const std::uint8_t* upper = sample_at(image, channel, x, y);
  return sample_bytes(image.layout) == 2 ? *upper + upper[-1] / 256.0 : *upper;
}

void set_value(const MutableNativeImage& image, int channel, int x, int y, double value) {
  std::uint8_t* upper = sample_at(image, channel, x, y);
  const auto whole = static_cast<unsigned>(value * words(image.layout));
  *upper = static_cast<std::uint8_t>(sample_bytes(image.layout) == 2 ? whole >> 8 : whole);
  if (sample_bytes(image.layout) == 2) upper[-1] = static_cast<std::uint8_t>(whole);
}

YuvFaces make_yuv_faces(const Rig& rig, NativeLayout layout, YuvColour colour, const TexelFunction& sample) {
  YuvFaces faces;
  for (std::size_t i = 0; i < rig.views.size(); ++i) {
    NativeBuffer buffer(layout, colour, rig.views[i].size);
    for (int channel = 0; channel < 3; ++channel) {
      const Size size = channel_size(as_const(buffer.pixels()), channel);
      for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
          set_value(buffer.pixels(), channel, x, y,
                    sample(static_cast<int>(i), channel, x, y) / steps(layout));
        }
      }
    }
    faces.buffers.push_back(std::move(buffer));
  }
  for (NativeBuffer& buffer : faces.buffers) faces.images.push_back(as_const(buffer.pixels()));
  return faces;
}

YuvFaces make_yuv_faces(const Rig& rig, NativeLayout layout, YuvColour colour,
                        const std::function<Vec3(const Vec3&)>& yuv, int noise) {
  std::mt19937 random(7);
  std::uniform_int_distribution<> grain(-noise, noise);
  return make_yuv_faces(rig, layout, colour, [&](int view, int channel, int x, int y) {
    const Vec2 texel = channel == 0                      ? Vec2{x + 0.5, y + 0.5}
                       : has_chroma_in_every_row(layout) ? Vec2{2 * x + 1.0, y + 0.5}
                                                         : Vec2{2 * x + 1.0, 2 * y + 1.0};
    const double value = yuv(direction_at(rig.views[static_cast<std::size_t>(view)], texel))[channel];
    const double added = channel == 0 ? grain(random) : 0;
    const double most = steps(layout) == 4.0 ? 1023.0 : 255.0;
    return static_cast<unsigned>(std::clamp(std::round((value + added) * steps(layout)), 0.0, most));
  });
}

Vec3 rgb_of(YuvColour colour, const Vec3& yuv, double white) {
  const double red = colour.matrix == YuvMatrix::kBt709 ? 0.2126 : 0.299;
  const double blue = colour.matrix == YuvMatrix::kBt709 ? 0.0722 : 0.114;
  const bool limited = colour.range == YuvRange::kLimited;
  const double y = limited ? (yuv[0] - 16.0) * 255.0 / 219.0 : yuv[0] * 255.0 / white;
  const double wide = limited ? 255.0 / 224.0 : 255.0 / white;
  const double r = y + 2.0 * (1.0 - red) * (yuv[2] - 128.0) * wide;
  const double b = y + 2.0 * (1.0 - blue) * (yuv[1] - 128.0) * wide;
  return {r, (y - red * r - blue * b) / (1.0 - red - blue), b};
}

Faces shown(const Rig& rig, const YuvFaces& faces) {
  Vec3 rgb{0.0};
  return make_faces(
      rig,
      [&](int view, int channel, int x, int y) {
        const NativeImage& face = faces.images[static_cast<std::size_t>(view)];
        if (channel == 0) {
          rgb = rgb_of(face.colour,
                       {value_at(face, 0, x, y), interpolated(face, 1, x, y), interpolated(face, 2, x, y)},
                       steps(face.layout) == 4.0 ? 255.75 : 255.0);
        }
        return static_cast<unsigned>(std::clamp(rgb[channel] * 257.0, 0.0, 65535.0) + 0.5);
      },
      PixelFormat::kRgbPlanar16);
}

}  // namespace cupola::test
