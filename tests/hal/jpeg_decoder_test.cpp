// Pictures of known samples come back as they went in, whatever their size; damage is damage.
// SPDX-License-Identifier: MIT
#include "hal/camera/jpeg_decoder.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "hal/camera/camera_planes.h"
#include "tests/hal/test_jpeg.h"

namespace cupola {
namespace {

using Outcome = JpegDecoder::Outcome;
using test::JpegMaking;

// Smooth, so that quality 100 errs by little.
int slope(int c, int x, int y) {
  return 40 + 50 * c + (3 * x + 2 * y) % 97;
}
int plain(int c, int x, int y) {
  return 60 + 30 * c + x / 2 + y / 4;
}

struct Planes {
  Planes(CameraFormat format, int width, int height) : memory(3), planes() {
    for (int p = 0; p < plane_count(format); ++p) {
      const PlaneShape shape = plane_shape(format, p, jpeg_room(width), jpeg_room(height));
      const auto i = static_cast<std::size_t>(p);
      memory[i].assign(static_cast<std::size_t>(shape.row_bytes * shape.rows), 0xa5);
      planes[i] = {memory[i].data(), shape.row_bytes};
    }
  }
  int at(int c, int x, int y) const {
    const auto i = static_cast<std::size_t>(c);
    return planes[i].data[y * planes[i].stride + x];
  }
  std::vector<std::vector<std::uint8_t>> memory;
  std::array<JpegPlane, 3> planes;
};

struct Kind {
  CameraFormat format;
  int components, across, down;
};
constexpr Kind kKinds[] = {
    {CameraFormat::kI420, 3, 2, 2}, {CameraFormat::kI422, 3, 2, 1}, {CameraFormat::kGrey, 1, 1, 1}};

JpegMaking making(const Kind& kind, int width, int height) {
  JpegMaking making;
  making.width = width;
  making.height = height;
  making.components = kind.components;
  making.across = kind.across;
  making.down = kind.down;
  return making;
}

TEST(JpegDecoder, GivesBackTheSamplesOfEveryKindAndSize) {
  JpegDecoder decoder;
  for (const Kind& kind : kKinds) {
    for (const auto& [width, height] :
         {std::pair(64, 48), std::pair(1, 1), std::pair(17, 9), std::pair(130, 75)}) {
      for (const bool tables : {true, false}) {
        JpegMaking how = making(kind, width, height);
        how.huffman_tables = tables;
        const std::vector<std::uint8_t> jpeg = test::make_jpeg(how, plain);
        const auto found = decoder.look(jpeg);
        ASSERT_TRUE(found) << width;
        EXPECT_EQ(*found, (JpegKind{kind.format, width, height}));
        Planes planes(kind.format, width, height);
        ASSERT_EQ(decoder.decode(jpeg, *found, planes.planes, height), Outcome::kDone);
        for (int c = 0; c < kind.components; ++c) {
          const PlaneShape shape = plane_shape(kind.format, c, width, height);
          for (int y = 0; y < shape.rows; ++y) {
            for (int x = 0; x < shape.row_bytes; ++x) {
              ASSERT_NEAR(planes.at(c, x, y), plain(c, x, y), 1) << c << ' ' << x << ' ' << y;
            }
          }
        }
      }
    }
  }
}

TEST(JpegDecoder, DecodesNoMoreRowsThanItIsAskedFor) {
  JpegDecoder decoder;
  for (const Kind& kind : kKinds) {
    const std::vector<std::uint8_t> jpeg = test::make_jpeg(making(kind, 64, 96), slope);
    Planes planes(kind.format, 64, 96);
    const JpegKind whole{kind.format, 64, 96};
    ASSERT_EQ(decoder.decode(jpeg, whole, planes.planes, 33), Outcome::kDone);
    EXPECT_NEAR(planes.at(0, 20, 32), slope(0, 20, 32), 8);
    EXPECT_EQ(planes.at(0, 20, 48), 0xa5) << "beyond the blocks of row 32";
    EXPECT_EQ(planes.at(0, 20, 95), 0xa5);
    // The next picture is not disturbed by the one that was left.
    ASSERT_EQ(decoder.decode(jpeg, whole, planes.planes, 96), Outcome::kDone);
    EXPECT_NEAR(planes.at(0, 20, 95), slope(0, 20, 95), 8);
  }
}

TEST(JpegDecoder, RefusesWhatItDoesNotRead) {
  JpegDecoder decoder;
  JpegMaking how;
  how.progressive = true;
  EXPECT_FALSE(decoder.look(test::make_jpeg(how, plain)));
  how = {};
  how.across = 1;
  how.down = 1;
  EXPECT_FALSE(decoder.look(test::make_jpeg(how, plain))) << "4:4:4";
  how.across = 4;
  EXPECT_FALSE(decoder.look(test::make_jpeg(how, plain))) << "4:1:1";
  how.rgb = true;
  EXPECT_FALSE(decoder.look(test::make_jpeg(how, plain)));
  EXPECT_FALSE(decoder.look({}));
  const std::vector<std::uint8_t> noise(100, 0x5a);
  EXPECT_FALSE(decoder.look(noise));
}

TEST(JpegDecoder, TellsAnotherKindFromDamage) {
  JpegDecoder decoder;
  const std::vector<std::uint8_t> jpeg = test::make_jpeg({}, slope);
  Planes planes(CameraFormat::kI420, 64, 48);
  EXPECT_EQ(decoder.decode(jpeg, {CameraFormat::kI422, 64, 48}, planes.planes, 48), Outcome::kOther);
  EXPECT_EQ(decoder.decode(jpeg, {CameraFormat::kI420, 64, 32}, planes.planes, 32), Outcome::kOther);
  EXPECT_EQ(planes.at(0, 0, 0), 0xa5) << "untouched";
  // Cut anywhere behind the header, it is damaged: libjpeg would fill up with grey.
  for (std::size_t bytes = jpeg.size() / 2; bytes + 2 < jpeg.size(); bytes += 97) {
    EXPECT_EQ(decoder.decode(std::span(jpeg).first(bytes), {CameraFormat::kI420, 64, 48}, planes.planes, 48),
              Outcome::kDamaged)
        << bytes;
  }
  EXPECT_EQ(decoder.decode(jpeg, {CameraFormat::kI420, 64, 48}, planes.planes, 48), Outcome::kDone)
      << "as before";
}

TEST(JpegDecoder, SurvivesAnyByteThatIsWrong) {
  JpegDecoder decoder;
  const std::vector<std::uint8_t> whole = test::make_jpeg({}, slope);
  Planes planes(CameraFormat::kI420, 64, 48);
  std::mt19937 random(3);
  int damaged = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::vector<std::uint8_t> jpeg = whole;
    jpeg[i] = static_cast<std::uint8_t>(random());
    decoder.look(jpeg);
    damaged +=
        decoder.decode(jpeg, {CameraFormat::kI420, 64, 48}, planes.planes, 48) != Outcome::kDone ? 1 : 0;
  }
  EXPECT_GT(damaged, 100);
}

}  // namespace
}  // namespace cupola
