// Rigs that are their own mirror image: which are, and that half a table gives the whole frame.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/symmetry.h"

#include <gtest/gtest.h>

#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

const std::vector<std::string> kFour = {"front", "left", "right", "top"};
const std::vector<std::string> kFive = {"front", "left", "right", "top", "bottom"};

Rig round_rig(Size frame, const std::vector<std::string>& names, Size face = {64, 64}) {
  Rig rig = test::omnimax_rig(frame, std::min(frame.width, frame.height), face, names);
  rig.frame.center = {frame.width / 2.0, frame.height / 2.0};
  return rig;
}

ImageBuffer warped(const WarpTable& table, const test::Faces& faces, Cpu cpu, WorkerPool& pool) {
  ImageBuffer frame(PixelFormat::kRgbPlanar8, table.frame);
  make_table_warp(table, cpu, pool)->warp(faces.images, frame.pixels());
  return frame;
}

TEST(Symmetry, IsFoundWhereTheFrameAndEveryViewHaveIt) {
  EXPECT_EQ(find_reflections(round_rig({96, 80}, kFour)).size(), 2U);
  EXPECT_EQ(find_reflections(round_rig({96, 80}, kFive)).size(), 4U);
  EXPECT_EQ(find_reflections(round_rig({96, 80}, {"front", "top", "bottom"})).size(), 4U);
  EXPECT_EQ(find_reflections(round_rig({96, 80}, {"front", "top", "left"})).size(), 1U);
  EXPECT_EQ(find_reflections(round_rig({97, 81}, kFive)).size(), 4U);
}

TEST(Symmetry, IsBrokenByWhateverIsNotTheSameOnBothSides) {
  Rig off_centre = round_rig({96, 80}, kFive);
  off_centre.frame.center.x += 0.5;
  ASSERT_EQ(find_reflections(off_centre).size(), 2U);
  EXPECT_TRUE(find_reflections(off_centre).front().down);

  Rig cropped = round_rig({96, 80}, kFive);
  cropped.frame.crop = Crop::kOmnimax;
  ASSERT_EQ(find_reflections(cropped).size(), 2U);
  EXPECT_TRUE(find_reflections(cropped).front().across);

  Rig unequal = round_rig({96, 80}, kFive);
  unequal.views[1].size = {65, 64};
  ASSERT_EQ(find_reflections(unequal).size(), 2U);
  EXPECT_TRUE(find_reflections(unequal).front().down);

  Rig turned = round_rig({96, 80}, kFive);
  std::swap(turned.views[1].right, turned.views[1].up);
  turned.views[1].right = -turned.views[1].right;
  ASSERT_EQ(find_reflections(turned).size(), 2U);
  EXPECT_TRUE(find_reflections(turned).front().down);

  Rig shifted = round_rig({96, 80}, kFive);
  shifted.views[0].principal.x = 0.51;
  EXPECT_EQ(find_reflections(shifted).size(), 1U);

  Rig beside = round_rig({96, 80}, kFive);
  beside.views[1].shift = {-0.1, 0.0, 0.05};
  ASSERT_EQ(find_reflections(beside).size(), 2U);
  EXPECT_TRUE(find_reflections(beside).front().down);
  beside.views[2].shift = {0.1, 0.0, 0.05};
  EXPECT_EQ(find_reflections(beside).size(), 4U);

  EXPECT_EQ(find_reflections(round_rig({96, 80}, kFive, {7, 64})).size(), 1U);  // smaller than a window
}

// A mirror image of the world gives the mirror image of the frame, to the bit.
TEST(Symmetry, IsExactInTheFrame) {
  WorkerPool pool(2);
  for (const Cpu cpu : {Cpu::kScalar, best_cpu()}) {
    for (const Size size : {Size{200, 150}, Size{130, 64}, Size{64, 66}}) {
      Rig rig = round_rig(size, kFive, {90, 77});
      rig.views[1].shift = {-0.05, 0.0, 0.02};
      rig.views[2].shift = {0.05, 0.0, 0.02};
      const WarpTable table = build_warp_table(rig, pool);
      ASSERT_EQ(table.reflections.size(), 4U);
      const test::Faces faces = test::make_faces(rig, test::noise(1));
      const ImageBuffer frame = warped(table, faces, cpu, pool);
      for (const Reflection& reflection : table.reflections) {
        const test::Faces seen = test::make_faces(rig, [&](int view, int channel, int x, int y) {
          const Reflection::Partner& partner = reflection.views[static_cast<std::size_t>(view)];
          return unsigned{faces.images[partner.view].samples<std::uint8_t>(
              channel, partner.flip_v ? 76 - y : y)[partner.flip_u ? 89 - x : x]};
        });
        const ImageBuffer mirrored = warped(table, seen, cpu, pool);
        for (int y = 0; y < size.height; ++y) {
          for (int x = 0; x < size.width; ++x) {
            const int there_x = reflection.across ? size.width - 1 - x : x;
            const int there_y = reflection.down ? size.height - 1 - y : y;
            ASSERT_EQ(mirrored.pixels().samples<std::uint8_t>(1, y)[x],
                      frame.pixels().samples<std::uint8_t>(1, there_y)[there_x])
                << x << ' ' << y;
          }
        }
      }
    }
  }
}

// Odd and even sizes, one pixel upward: every pixel is within the table's rounding of the reference.
TEST(Symmetry, GivesTheReferenceInEveryPartOfTheFrame) {
  WorkerPool pool(2);
  for (const Size size :
       {Size{1, 1}, Size{2, 1}, Size{1, 2}, Size{5, 4}, Size{65, 33}, Size{128, 64}, Size{131, 97}}) {
    for (const std::vector<std::string>& names : {kFour, kFive}) {
      Rig rig = round_rig(size, names, {40, 48});
      rig.filter.table = TableForm::kPrecise;
      const WarpTable table = build_warp_table(rig, pool);
      const test::Faces faces = test::make_faces(rig, test::noise(2));
      const ImageBuffer frame = warped(table, faces, best_cpu(), pool);
      for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
          const auto exact = ewa_exact(rig, faces.images, x, y);
          for (int channel = 0; channel < 3; ++channel) {
            ASSERT_NEAR(frame.pixels().samples<std::uint8_t>(channel, y)[x], exact[channel], 1.0)
                << size.width << " x " << size.height << ": " << x << ' ' << y;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace cupola
