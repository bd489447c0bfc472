// Focus and exposure of pictures whose edges and levels are known.
// SPDX-License-Identifier: MIT
#include "firmware/camera_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace cupola {
namespace {

constexpr int kSide = 128;

// Stripes 32 texels wide, dark and bright, their edges blurred by a Gaussian of `sigma` texels.
std::vector<std::uint8_t> stripes(double sigma, int step, int first, double dark, double bright) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(kSide * kSide * step), 128);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      double share = 0.0;
      for (int edge = 16; edge < kSide; edge += 32) {
        const double rise = 0.5 * std::erfc((edge - (x + 0.5)) / (std::sqrt(2.0) * sigma));
        share += (edge / 32) % 2 == 0 ? rise : -rise;
      }
      bytes[static_cast<std::size_t>((y * kSide + x) * step + first)] =
          static_cast<std::uint8_t>(std::lround(dark + (bright - dark) * share));
    }
  }
  return bytes;
}

CameraFrame frame_of(const std::vector<std::uint8_t>& bytes, CameraFormat format, int step) {
  CameraFrame frame;
  frame.format = format;
  frame.width = kSide;
  frame.height = kSide;
  frame.planes[0] = {bytes.data(), kSide * step, bytes.size()};
  return frame;
}

// A blurred edge's steepest texel is 1 / (2.507 sigma) of it: 2.5 sigma, and at 1 texel and less the texel's
// own width.
TEST(CameraPicture, SaysHowWideTheSharpestEdgesAre) {
  for (const double sigma : {1.0, 2.0, 4.0}) {
    const std::vector<std::uint8_t> bytes = stripes(sigma, 1, 0, 40.0, 200.0);
    const auto facts = look_at(frame_of(bytes, CameraFormat::kGrey, 1), {});
    ASSERT_TRUE(facts);
    EXPECT_NEAR(facts->edge_texels, 2.507 * sigma, 0.12 * 2.507 * sigma) << sigma;
  }
  const std::vector<std::uint8_t> sharp = stripes(0.05, 1, 0, 40.0, 200.0);
  EXPECT_NEAR(look_at(frame_of(sharp, CameraFormat::kNv12, 1), {})->edge_texels, 1.0, 0.01);
}

TEST(CameraPicture, FindsTheBrightnessInEveryFormatAndKnowsItsRange) {
  struct Kind {
    CameraFormat format;
    int step;
    int first;
    bool rgb;
  };
  for (const Kind& kind : {Kind{CameraFormat::kYuyv, 2, 0, false}, Kind{CameraFormat::kUyvy, 2, 1, false},
                           Kind{CameraFormat::kP010, 2, 1, false}, Kind{CameraFormat::kRgb24, 3, 1, true},
                           Kind{CameraFormat::kXrgb32, 4, 1, true}}) {
    const double white = kind.rgb ? 255.0 : 235.0;
    const double black = kind.rgb ? 0.0 : 16.0;
    const std::vector<std::uint8_t> bytes = stripes(0.05, kind.step, kind.first, black, white);
    const auto facts = look_at(frame_of(bytes, kind.format, kind.step), {});
    ASSERT_TRUE(facts);
    EXPECT_NEAR(facts->mean, 0.5, 0.02) << static_cast<int>(kind.format);
    EXPECT_NEAR(facts->white_share, 0.5, 0.02) << static_cast<int>(kind.format);
    EXPECT_NEAR(facts->edge_texels, 1.0, 0.01);
  }
}

TEST(CameraPicture, IsCopiedAsBrightnesses) {
  struct Kind {
    CameraFormat format;
    int step;
    int first;
  };
  for (const Kind& kind :
       {Kind{CameraFormat::kGrey, 1, 0}, Kind{CameraFormat::kNv12, 1, 0}, Kind{CameraFormat::kYuyv, 2, 0},
        Kind{CameraFormat::kUyvy, 2, 1}, Kind{CameraFormat::kP010, 2, 1}, Kind{CameraFormat::kBgr24, 3, 1},
        Kind{CameraFormat::kXrgb32, 4, 1}}) {
    constexpr int kGap = 3;  // texels that are in memory beside each row
    const std::vector<std::uint8_t> bytes = stripes(2.0, kind.step, kind.first, 16.0, 235.0);
    CameraFrame frame = frame_of(bytes, kind.format, kind.step);
    frame.width -= kGap;
    const auto grey = grey_of(frame);
    ASSERT_TRUE(grey);
    ASSERT_EQ(grey->size, (Size{kSide - kGap, kSide}));
    const std::vector<std::uint8_t> plain = stripes(2.0, 1, 0, 16.0, 235.0);
    for (int y = 0; y < kSide; y += 7) {
      for (int x = 0; x < kSide - kGap; ++x) {
        ASSERT_EQ(grey->texels[static_cast<std::size_t>(y * (kSide - kGap) + x)],
                  plain[static_cast<std::size_t>(y * kSide + x)])
            << name_of(kind.format) << " " << x << " " << y;
      }
    }
  }
}

TEST(CameraPicture, SaysNothingOfJpegOrOfWhatIsCutShort) {
  const std::vector<std::uint8_t> bytes = stripes(1.0, 1, 0, 40.0, 200.0);
  EXPECT_FALSE(look_at(frame_of(bytes, CameraFormat::kMjpeg, 1), {}));
  CameraFrame cut = frame_of(bytes, CameraFormat::kGrey, 1);
  cut.planes[0].bytes -= 1;
  EXPECT_FALSE(look_at(cut, {}));
  EXPECT_FALSE(grey_of(cut));
  const std::vector<std::uint8_t> even(kSide * kSide, 100);
  EXPECT_EQ(look_at(frame_of(even, CameraFormat::kGrey, 1), {})->edge_texels, 0.0) << "no edges, no focus";
}

}  // namespace
}  // namespace cupola
