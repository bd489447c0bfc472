// Frames and faces of awkward sizes: single pixels, odd sides, and offsets beyond 2^31 bytes.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <memory>

#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"
#include "tests/stress/random_rigs.h"
#include "tests/stress/sparse_memory.h"
#include "tests/warp/block_check.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

const std::vector<std::string> kFive = {"front", "left", "right", "top", "bottom"};

Rig rig_of(Size frame, Size face) {
  Rig rig = test::omnimax_rig(frame, std::max(frame.width, frame.height), face, kFive);
  rig.frame.center = {frame.width / 2.0, frame.height / 2.0};
  return rig;
}

TEST(SizesStress, EverySmallOrOddSizeIsTheReferences) {
  WorkerPool pool(2);
  for (const Size frame : {Size{1, 1}, Size{1, 97}, Size{97, 1}, Size{2, 2}, Size{3, 5}, Size{63, 31},
                           Size{65, 33}, Size{129, 67}}) {
    for (const Size face : {Size{1, 1}, Size{1, 9}, Size{7, 8}, Size{33, 57}}) {
      SCOPED_TRACE(std::to_string(frame.width) + " x " + std::to_string(frame.height) + " from " +
                   std::to_string(face.width) + " x " + std::to_string(face.height));
      Rig rig = rig_of(frame, face);
      rig.filter.table = TableForm::kPrecise;
      const WarpTable table = build_warp_table(rig, pool);
      test::expect_sound(table);
      const test::Faces faces = test::make_faces(rig, test::noise(1));
      ImageBuffer out(PixelFormat::kRgbPlanar8, frame);
      make_table_warp(table, best_cpu(), pool)->warp(faces.images, out.pixels());
      for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
          const auto exact = ewa_exact(rig, faces.images, x, y);
          for (int c = 0; c < 3; ++c) {
            ASSERT_NEAR(out.pixels().samples<std::uint8_t>(c, y)[x], exact[c], 1.0) << x << ' ' << y;
          }
        }
      }
    }
  }
}

void copy_rows(const Image& from, const MutableImage& to) {
  for (int plane = 0; plane < plane_count(from.format); ++plane) {
    for (int y = 0; y < from.size.height; ++y) {
      std::copy_n(from.planes[plane].row(y),
                  static_cast<std::ptrdiff_t>(from.size.width) * pixel_step(from.format),
                  to.planes[plane].row(y));
    }
  }
}

// 97 rows, 64 MiB apart: 6 GiB a plane.
TEST(SizesStress, RowsMayLieAnyDistanceApartForEveryMethod) {
  constexpr std::ptrdiff_t kStride = std::ptrdiff_t{64} << 20;
  WorkerPool pool(2);
  const Rig rig = test::omnimax_rig({131, 97}, 131, {97, 97}, {"front", "left", "right", "top"});
  const test::Faces faces = test::make_faces(rig, test::noise(2));
  std::vector<std::unique_ptr<test::SparseImage>> far;
  std::vector<Image> far_images;
  for (const Image& face : faces.images) {
    far.push_back(std::make_unique<test::SparseImage>(face.format, face.size, kStride));
    ASSERT_FALSE(far.back()->empty());
    copy_rows(face, far.back()->pixels());
    far_images.push_back(as_const(far.back()->pixels()));
  }
  for (std::size_t method = 0; method < std::size(kMethodNames); ++method) {
    for (const Cpu cpu : {Cpu::kScalar, best_cpu()}) {
      for (const PixelFormat format :
           {PixelFormat::kRgbPlanar8, PixelFormat::kXrgb8888, PixelFormat::kRgb16}) {
        SCOPED_TRACE(kMethodNames[method]);
        const auto warp = make_frame_warp(rig, static_cast<Method>(method), cpu, pool);
        ImageBuffer near_frame(format, rig.frame.size);
        test::SparseImage far_frame(format, rig.frame.size, kStride);
        ASSERT_FALSE(far_frame.empty());
        warp->warp(faces.images, near_frame.pixels());
        warp->warp(far_images, far_frame.pixels());
        ASSERT_TRUE(test::same_pixels(as_const(near_frame.pixels()), as_const(far_frame.pixels())));
      }
      if (static_cast<Method>(method) != Method::kEwa) break;
    }
  }
}

// The far corners of faces of 4 Gi texels.
TEST(SizesStress, FacesOf65535TexelsSquareAreReadWhereTheyShould) {
  WorkerPool pool(2);
  for (const int side : {16384, 65535}) {
    Rig rig = test::omnimax_rig({96, 64}, 96, {side, side}, {"front"});
    rig.frame.lens = equidistant(2.0 * 16384 / side);
    const Vec3 corner = direction_at(rig.views[0], {side - 40.0, side - 40.0});
    const Vec3 right = glm::normalize(glm::cross(corner, Vec3{0, 1, 0}));
    // Turn the view so that its lower right corner is on the axis.
    const Mat3 turn = glm::transpose(Mat3{right, glm::cross(right, corner), -corner});
    rig.views[0].forward = turn * rig.views[0].forward;
    rig.views[0].right = turn * rig.views[0].right;
    rig.views[0].up = turn * rig.views[0].up;
    rig.filter.table = TableForm::kPrecise;
    const WarpTable table = build_warp_table(rig, pool);
    test::expect_sound(table);
    test::SparseImage face(PixelFormat::kRgbPlanar8, {side, side}, side);
    ASSERT_FALSE(face.empty());
    const NeededRegion& needed = table.needed[0];
    for (int y = 0; y < side; ++y) {
      for (int x = needed.rows[y].first; x < needed.rows[y].last; ++x) {
        for (int c = 0; c < 3; ++c) {
          face.pixels().samples<std::uint8_t>(c, y)[x] =
              static_cast<std::uint8_t>((x * 7 + y * 13 + c * 50) * 37 >> 3);
        }
      }
    }
    EXPECT_FALSE(needed.rows[side - 1].empty());
    const std::vector<Image> faces = {as_const(face.pixels())};
    for (const Method method : {Method::kEwa, Method::kEwaScanInteger, Method::kTwoPass}) {
      ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
      const auto warp = method == Method::kEwa ? make_table_warp(table, best_cpu(), pool)
                                               : make_frame_warp(rig, method, best_cpu(), pool);
      warp->warp(faces, frame.pixels());
      int covered = 0;
      for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 96; ++x) {
          const auto exact = ewa_exact(rig, faces, x, y);
          covered += exact[0] + exact[1] + exact[2] > 0.0 ? 1 : 0;
          for (int c = 0; c < 3; ++c) {
            ASSERT_NEAR(frame.pixels().samples<std::uint8_t>(c, y)[x], exact[c],
                        method == Method::kTwoPass ? 30.0 : 1.5)
                << x << ' ' << y << ' ' << kMethodNames[static_cast<int>(method)] << ' ' << side;
          }
        }
      }
      EXPECT_GT(covered, 100);
    }
  }
}

// A frame of 65535 pixels across, of which a few are in the image.
TEST(SizesStress, PixelsFarToTheRightAreWhereTheyShouldBe) {
  WorkerPool pool(2);
  Rig rig = test::omnimax_rig({65535, 40}, 60, {40, 40}, kFive);
  rig.frame.center = {65515.0, 20.0};
  rig.frame.radius = 19.5;
  rig.filter.table = TableForm::kPrecise;
  const WarpTable table = build_warp_table(rig, pool);
  test::expect_sound(table);
  const test::Faces faces = test::make_faces(rig, test::noise(3));
  ImageBuffer frame(PixelFormat::kXrgb8888, rig.frame.size);
  make_table_warp(table, best_cpu(), pool)->warp(faces.images, frame.pixels());
  for (int y = 0; y < 40; ++y) {
    for (int x = 65400; x < 65535; ++x) {
      const auto exact = ewa_exact(rig, faces.images, x, y);
      ASSERT_NEAR(frame.pixels().samples<std::uint32_t>(0, y)[x] >> 16 & 255, exact[0], 1.0) << x << ' ' << y;
    }
  }
}

}  // namespace
}  // namespace cupola
