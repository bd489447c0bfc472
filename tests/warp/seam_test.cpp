// Seams: an analytic scene shows no more error in the band about the faces' edges than elsewhere.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/optics/frame_map.h"
#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

bool near_seam(const FrameMap& map, int x, int y) {
  constexpr int kBand = 2;
  for (int dy = -kBand; dy <= kBand; ++dy) {
    for (int dx = -kBand; dx <= kBand; ++dx) {
      const int nx = x + dx;
      const int ny = y + dy;
      if (nx < 0 || ny < 0 || nx >= map.size.width || ny >= map.size.height) continue;
      const std::uint8_t other = map.at(nx, ny);
      if (other < FrameMap::kUncovered && other != map.at(x, y)) return true;
    }
  }
  return false;
}

TEST(Seam, ZonePlateErrsNoMoreThereThanElsewhere) {
  WorkerPool pool(0);
  Rig rig = test::omnimax_rig({983, 718}, 983, {512, 512}, {"front", "left", "right", "top"});
  const WarpTable table = build_warp_table(rig, pool);
  const FrameMap map = map_frame(rig, pool);
  // Rings about a direction off every axis and seam; 0.35 rad a ring at most is resolved by faces and frame.
  const Vec3 centre = glm::normalize(Vec3{0.3, 0.35, -1.0});
  const auto zone_plate = [&](const Vec3& d) {
    const double angle = std::acos(std::clamp(glm::dot(d, centre), -1.0, 1.0));
    return Vec3{0.5 + 0.45 * std::cos(30.0 * angle * angle)};
  };
  const test::Faces faces = test::make_faces(rig, zone_plate);
  ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
  make_table_warp(table, best_cpu(), pool)->warp(faces.images, frame.pixels());

  // The truth is the pixel's box integral; 8 x 8 points resolve rings this wide.
  double squares[2] = {};
  std::int64_t count[2] = {};
  for (int y = 0; y < map.size.height; ++y) {
    for (int x = 0; x < map.size.width; ++x) {
      if (map.at(x, y) >= FrameMap::kUncovered) continue;
      // Compare like with like: a ring about the centre of the frame through which the seams run.
      const double r = std::hypot(x + 0.5 - 491.5, y + 0.5 - 491.5);
      if (r < 260 || r > 400) continue;
      double truth = 0;
      for (int sample = 0; sample < 64; ++sample) {
        DirectionAndSlope looking;
        ray(rig.frame, {x + (sample % 8 + 0.5) / 8, y + (sample / 8 + 0.5) / 8}, looking);
        truth += zone_plate(looking.direction).x * 255 / 64;
      }
      const double error = frame.pixels().samples<std::uint8_t>(0, y)[x] - truth;
      const int band = near_seam(map, x, y) ? 1 : 0;
      squares[band] += error * error;
      ++count[band];
    }
  }
  ASSERT_GT(count[1], 2000);
  const auto psnr = [&](int band) {
    return 10 * std::log10(255.0 * 255.0 * static_cast<double>(count[band]) / squares[band]);
  };
  std::printf("PSNR within 2 px of a seam %.2f dB (%ld px), elsewhere %.2f dB (%ld px)\n", psnr(1), count[1],
              psnr(0), count[0]);
  EXPECT_GT(psnr(1), psnr(0) - 1.0);
  EXPECT_GT(psnr(0), 35.0) << "faces and frame both resolve the scene";
}

TEST(Seam, IsInvisibleOnASmoothScene) {
  // On a scene linear in direction every seam pixel is within rounding of the truth.
  WorkerPool pool(0);
  Rig rig = test::omnimax_rig({400, 400}, 400, {256, 256}, {"front", "left", "right", "top", "bottom"});
  const auto smooth = [](const Vec3& d) { return Vec3{0.5 + 0.3 * d.x, 0.5 + 0.3 * d.y, 0.5 - 0.3 * d.z}; };
  const test::Faces faces = test::make_faces(rig, smooth);
  ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
  const WarpTable table = build_warp_table(rig, pool);
  make_table_warp(table, best_cpu(), pool)->warp(faces.images, frame.pixels());
  const FrameMap map = map_frame(rig, pool);
  for (int y = 0; y < 400; ++y) {
    for (int x = 0; x < 400; ++x) {
      if (map.at(x, y) >= FrameMap::kUncovered || !near_seam(map, x, y)) continue;
      DirectionAndSlope looking;
      ray(rig.frame, {x + 0.5, y + 0.5}, looking);
      // Footprints at the limb lack the texels beyond the four or five faces' outer edges.
      if (looking.direction.z > -0.05) continue;
      const Vec3 truth = smooth(looking.direction) * 255.0;
      for (int channel = 0; channel < 3; ++channel) {
        ASSERT_NEAR(frame.pixels().samples<std::uint8_t>(channel, y)[x], truth[channel], 1.3)
            << x << ' ' << y;
      }
    }
  }
}

}  // namespace
}  // namespace cupola
