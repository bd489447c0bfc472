// Parts of pictures against the sensor's texels.
// SPDX-License-Identifier: MIT
#include "pipeline/source/face_part.h"

#include <gtest/gtest.h>

#include <random>

namespace cupola {
namespace {

CameraMode mode(int width, int height, CameraArea crop) {
  CameraMode mode;
  mode.width = width;
  mode.height = height;
  mode.crop = crop;
  return mode;
}

void expect_box(const std::optional<TexelBox>& box, const TexelBox& expected) {
  ASSERT_TRUE(box);
  EXPECT_EQ(box->x0, expected.x0);
  EXPECT_EQ(box->y0, expected.y0);
  EXPECT_EQ(box->x1, expected.x1);
  EXPECT_EQ(box->y1, expected.y1);
}

TEST(FacePart, IsFoundTexelOnTexelOnly) {
  const CameraMode whole = mode(1920, 1080, {0, 0, 1920, 1080});
  expect_box(place_of(whole, whole), {0, 0, 1920, 1080});
  expect_box(place_of(mode(960, 540, {100, 200, 960, 540}), whole), {100, 200, 1060, 740});
  EXPECT_FALSE(place_of(mode(960, 540, {101, 200, 960, 540}), whole)) << "chroma between chroma";
  EXPECT_FALSE(place_of(mode(1920, 1080, {100, 200, 960, 540}), whole)) << "enlarged";
  EXPECT_FALSE(place_of(mode(960, 540, {1000, 600, 960, 540}), whole)) << "beyond the picture";
  EXPECT_FALSE(place_of(mode(960, 540, {-2, 0, 960, 540}), whole));
  // Every texel two by two of the sensor's.
  const CameraMode binned = mode(1640, 1232, {0, 0, 3280, 2464});
  expect_box(place_of(mode(820, 616, {1640, 4, 1640, 1232}), binned), {820, 2, 1640, 618});
  EXPECT_FALSE(place_of(mode(820, 616, {1638, 4, 1640, 1232}), binned)) << "an odd texel";
  // A rig's own crop is the whole.
  const CameraMode square = mode(1080, 1080, {420, 0, 1080, 1080});
  expect_box(place_of(mode(540, 1080, {960, 0, 540, 1080}), square), {540, 0, 1080, 1080});
}

TEST(FacePart, OfAnUnknownWholeIsTheWhole) {
  const CameraMode whole = mode(64, 48, {});
  expect_box(place_of(mode(64, 48, {0, 0, 64, 48}), whole), {0, 0, 64, 48});
  EXPECT_FALSE(place_of(mode(32, 48, {0, 0, 32, 48}), whole));
}

TEST(FacePart, OfAnotherFormatOrColourIsNone) {
  const CameraMode whole = mode(64, 48, {0, 0, 64, 48});
  CameraMode part = whole;
  part.format = CameraFormat::kUyvy;
  EXPECT_FALSE(place_of(part, whole));
  part = whole;
  part.bt709 = true;
  EXPECT_FALSE(place_of(part, whole));
  part = whole;
  part.full_range = true;
  EXPECT_FALSE(place_of(part, whole));
}

TEST(FacePart, ThatWasAskedForHoldsTheBox) {
  std::mt19937 random(7);
  const auto between = [&](int least, int most) {
    return std::uniform_int_distribution<int>(least, most)(random);
  };
  for (int i = 0; i < 10'000; ++i) {
    const CameraMode whole = mode(between(2, 4096), between(2, 4096),
                                  {between(0, 99), between(0, 99), between(2, 65535), between(2, 65535)});
    TexelBox box{between(0, whole.width - 1), between(0, whole.height - 1), 0, 0};
    box.x1 = between(box.x0 + 1, whole.width);
    box.y1 = between(box.y0 + 1, whole.height);
    const CameraArea area = area_of(box, whole);
    const double scale = 1.0 * whole.crop.width / whole.width;
    EXPECT_LE(area.x - whole.crop.x, box.x0 * scale + 1e-6);
    EXPECT_GE(area.x + area.width - whole.crop.x, box.x1 * scale - 1e-6);
    EXPECT_LE(area.x + area.width, whole.crop.x + whole.crop.width);
    EXPECT_LE(area.y + area.height, whole.crop.y + whole.crop.height);
    EXPECT_GE(area.height, 1);
    // At the sensor's own scale the area is the box, and is found again.
    const CameraMode same = mode(whole.width, whole.height, {4, 6, whole.width, whole.height});
    const TexelBox even{box.x0 / 2 * 2, box.y0 / 2 * 2, box.x1, box.y1};
    const CameraArea exact = area_of(even, same);
    expect_box(place_of(mode(exact.width, exact.height, exact), same), even);
  }
}

}  // namespace
}  // namespace cupola
