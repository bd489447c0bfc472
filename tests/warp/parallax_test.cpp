// Four cameras side by side look at a sphere: seams close at the stated distance, and open elsewhere as told.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/parallax.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"
#include "pipeline/warp/table_key.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

constexpr double kCloses = 4.0;  // metres

// 110 degrees each, eyes 6 to 9 cm off the centre.
Rig four_cameras(double distance_m) {
  Rig rig = test::omnimax_rig({240, 240}, 240, {200, 200}, {"front", "left", "right", "top"});
  for (View& view : rig.views) {
    view.focal = {0.35, 0.35};
    view.position_m = 0.06 * view.forward + 0.05 * view.right - 0.02 * view.up;
  }
  rig.seams.distance_m = distance_m;
  EXPECT_TRUE(set_shifts(rig.views, distance_m));
  return rig;
}

// What the cameras see of a sphere about the centre, painted `colour` by direction from there.
test::Faces seen_of_sphere(const Rig& rig, double radius_m, const std::function<Vec3(const Vec3&)>& colour) {
  Rig there = rig;
  EXPECT_TRUE(set_shifts(there.views, radius_m));
  return test::make_faces(there, colour, 2);
}

Vec3 slopes(const Vec3& d) {
  return 0.5 + 0.45 * d;
}

ImageBuffer warped(const Rig& rig, const test::Faces& faces) {
  WorkerPool pool(0);
  const WarpTable table = build_warp_table(rig, pool);
  ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
  make_table_warp(table, best_cpu(), pool)->warp(faces.images, frame.pixels());
  return frame;
}

// The largest difference to the scene itself, 8-bit steps.
double worst(const Rig& rig, const ImageBuffer& frame) {
  double largest = 0.0;
  for (int y = 0; y < rig.frame.size.height; ++y) {
    for (int x = 0; x < rig.frame.size.width; ++x) {
      DirectionAndSlope looking;
      if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking) || owner(rig.views, looking.direction) < 0) continue;
      for (int channel = 0; channel < 3; ++channel) {
        const double value = frame.pixels().samples<std::uint8_t>(channel, y)[x];
        largest = std::max(largest, std::abs(value - 255.0 * slopes(looking.direction)[channel]));
      }
    }
  }
  return largest;
}

TEST(Parallax, OfASphereAtTheDistanceThatIsStatedThereIsNone) {
  for (const double feather_deg : {0.0, 8.0}) {
    Rig rig = four_cameras(kCloses);
    rig.seams.feather_deg = feather_deg;
    const test::Faces faces = seen_of_sphere(rig, kCloses, slopes);
    EXPECT_LT(worst(rig, warped(rig, faces)), 1.6);
    Rig at_infinity = four_cameras(HUGE_VAL);
    at_infinity.seams.feather_deg = feather_deg;
    EXPECT_GT(worst(at_infinity, warped(at_infinity, faces)), 2.3) << "without the shifts it is seen";
  }
  EXPECT_LT(parallax_at_seams(four_cameras(kCloses), kCloses).texels, 1e-9);
}

// Where the sphere shows what the frame shows of view `v` in direction d: the eye's ray, followed the long
// way.
Vec3 met(const View& view, const Vec3& d, double distance_m) {
  const Vec3 p = view.position_m;
  const Vec3 w = glm::normalize(d * kCloses - p);
  if (std::isinf(distance_m)) return w;
  const double along = glm::dot(p, w);
  const double t = -along + std::sqrt(along * along + distance_m * distance_m - glm::dot(p, p));
  return (p + t * w) / distance_m;
}

TEST(Parallax, AtOtherDistancesIsWhatTheFormulaSays) {
  const Rig rig = four_cameras(kCloses);
  for (const double distance_m : {1.0, 2.0, 8.0, HUGE_VAL}) {
    const SeamParallax predicted = parallax_at_seams(rig, distance_m);
    ASSERT_GE(predicted.first, 0);
    const View& a = rig.views[static_cast<std::size_t>(predicted.first)];
    const View& b = rig.views[static_cast<std::size_t>(predicted.second)];
    double measured = 0.0;
    for (double along = -1.5; along <= 1.5; along += 0.01) {
      const Vec3 d = glm::normalize(a.forward + b.forward + along * glm::cross(a.forward, b.forward));
      const int own = owner(rig.views, d);
      if (d.z > 0.0 || (own != predicted.first && own != predicted.second)) continue;
      measured = std::max(measured, glm::length(met(a, d, distance_m) - met(b, d, distance_m)));
    }
    EXPECT_NEAR(predicted.radians / measured, 1.0, 0.1) << distance_m;
    const double on_axis = predicted.radians * 0.35 * 200;  // a texel at the seam is up to twice as fine
    EXPECT_TRUE(predicted.texels > on_axis && predicted.texels < 3.0 * on_axis) << predicted.texels;
    // To first order: the eyes' distance across the ray, by the difference of both distances' inverses.
    const double first_order =
        glm::length(a.position_m - b.position_m) * std::abs(1.0 / distance_m - 1.0 / kCloses);
    EXPECT_LT(predicted.radians, 1.1 * first_order) << distance_m;
    EXPECT_GT(predicted.radians, 0.7 * first_order) << distance_m;
  }
}

TEST(Parallax, LeavesTablesAloneWhereEyesAreInTheCentreOrSeamsCloseAtInfinity) {
  WorkerPool pool(0);
  const Rig moved = four_cameras(HUGE_VAL);
  Rig centred = moved;
  for (View& view : centred.views) view.position_m = Vec3{0.0};
  EXPECT_EQ(table_key(moved), table_key(centred));
  const WarpTable a = build_warp_table(moved, pool);
  const WarpTable b = build_warp_table(centred, pool);
  EXPECT_TRUE(std::ranges::equal(std::as_bytes(a.lines), std::as_bytes(b.lines)));
  EXPECT_TRUE(std::ranges::equal(std::as_bytes(a.windows), std::as_bytes(b.windows)));
  EXPECT_NE(table_key(four_cameras(kCloses)), table_key(centred));
}

}  // namespace
}  // namespace cupola
