// The bounds of the YUV warp against the reference: chroma interpolated, converted to RGB, filtered,
// unrounded.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/native_warp.h"
#include "tests/warp/yuv_faces.h"

namespace cupola {
namespace {

constexpr YuvColour kColour{YuvMatrix::kBt709, YuvRange::kLimited};

// Within what RGB can show; details of a sixth of a radian and more.
Vec3 smooth(const Vec3& d) {
  return {126.0 + 30.0 * std::sin(9.0 * d.x + 4.0 * d.y), 128.0 + 22.0 * std::sin(6.0 * d.y - 3.0 * d.z),
          128.0 + 22.0 * std::cos(7.0 * d.x + 2.0 * d.z)};
}

// The real matrix backwards, chroma as the photograph has it at a point.
Vec3 photographed(const Vec3& d) {
  static const auto picture = test::photograph();
  const Vec3 rgb = picture(d);
  const double y = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
  return {16.0 + 219.0 * y, 128.0 + 224.0 * (rgb[2] - y) / 1.8556, 128.0 + 224.0 * (rgb[0] - y) / 1.5748};
}

struct Content {
  const char* name;
  Vec3 (*yuv)(const Vec3&);
  int noise;              // of luma
  double rms[2], max[2];  // 4:2:0, 4:2:2
};

TEST(YuvAccuracy, XrgbStaysWithinItsBoundOfTheReference) {
  WorkerPool pool(0);
  const Rig rig = test::omnimax_rig({600, 438}, 600, {312, 312}, {"front", "left", "right", "top"});
  const Content contents[] = {{"smooth", smooth, 0, {0.33, 0.33}, {1.5, 1.5}},
                              {"noise in luma", smooth, 35, {0.33, 0.33}, {1.5, 1.5}},
                              {"photograph", photographed, 0, {0.33, 0.33}, {4, 4}}};
  for (const Content& content : contents) {
    for (const NativeLayout layout : {NativeLayout::kNv12, NativeLayout::kYuyv}) {
      const bool packed = is_packed(layout);
      const test::YuvFaces faces = test::make_yuv_faces(rig, layout, kColour, content.yuv, content.noise);
      std::vector<double> exact = ewa_exact_frame(rig, test::shown(rig, faces).images, pool);
      for (double& sample : exact) sample /= 257.0;
      ImageBuffer frame(PixelFormat::kXrgb8888, rig.frame.size);
      make_native_to_xrgb_warp(rig, layout, best_cpu(), pool)->warp(faces.images, frame.pixels());
      ImageBuffer planar(PixelFormat::kRgbPlanar8, rig.frame.size);
      convert(as_const(frame.pixels()), planar.pixels());
      const test::Difference d = test::difference(rig, as_const(planar.pixels()), exact);
      std::printf("%s, %s: rms %.3f, max %.2f LSB\n", content.name, packed ? "4:2:2" : "4:2:0", d.rms, d.max);
      EXPECT_LE(d.rms, content.rms[packed]) << content.name;
      EXPECT_LE(d.max, content.max[packed]) << content.name << " at " << d.x << ' ' << d.y;
      EXPECT_GT(d.samples, 500'000);
    }
  }
}

}  // namespace
}  // namespace cupola
