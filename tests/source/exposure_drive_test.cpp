// Cameras that answer as cameras do, late and with noise: the brightness is reached, and then left alone.
// SPDX-License-Identifier: MIT
#include "pipeline/source/exposure_drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr Size kSize{96, 64};
constexpr nanoseconds kPeriod = 16'666'667ns;
constexpr int kSecond = 60;  // frames

// `light` of 1 is as bright as wanted at 4 ms without gain.
struct Rig {
  explicit Rig(const ExposureLimits& within = {}, double curve = 2.2)
      : limits(within), gamma(curve), drive(within, {whole(), whole(), whole()}) {
    for (int v = 0; v < 3; ++v) {
      faces.emplace_back(NativeLayout::kNv12, YuvColour{}, kSize);
      seen_of.push_back(as_const(faces.back().pixels()));
    }
  }
  static TexelBox whole() { return {0, 0, kSize.width, kSize.height}; }

  // One frame of all cameras, with what they were told five frames ago.
  bool step(unsigned seen = 7) {
    told.push_back(drive.exposure());
    if (told.size() > 5) told.pop_front();
    const double signal = light * told.front().us * told.front().gain / 4000.0;
    mean = std::min(1.0, limits.brightness * std::pow(signal, 1.0 / gamma));
    for (std::size_t v = 0; v < 3; ++v) {
      // A hash's noise: +- 2 per cent of white from frame to frame.
      const auto hash = static_cast<std::uint32_t>((frame + 1) * 2654435761U + v * 40503U);
      const double noise = 0.04 * (static_cast<double>(hash >> 8) / 16777216.0 - 0.5);
      const double level = (seen >> v & 1) != 0 ? mean + noise : 0.0;
      const auto luma = static_cast<std::uint8_t>(std::clamp(16.0 + 219.0 * level + 0.5, 16.0, 235.0));
      for (int y = 0; y < kSize.height; ++y)
        std::fill_n(faces[v].pixels().planes[0].row(y), kSize.width, luma);
    }
    return drive.look(seen_of, seen, ++frame * kPeriod);
  }
  // The number of changes.
  int run(int frames) {
    int changes = 0;
    for (int i = 0; i < frames; ++i) changes += step() ? 1 : 0;
    return changes;
  }
  double off() const { return mean / limits.brightness - 1.0; }

  ExposureLimits limits;
  double gamma;
  ExposureDrive drive;
  std::vector<NativeBuffer> faces;
  std::vector<NativeImage> seen_of;
  std::deque<Exposure> told;
  double light = 1.0;
  double mean = 0.0;
  int frame = 0;
};

TEST(ExposureDrive, ReachesTheBrightnessAndThenStandsWhateverTheCamerasCurve) {
  for (const double gamma : {1.6, 2.2, 2.8}) {
    for (const double stops : {-1.0, 0.0, 2.0, 4.0}) {
      Rig rig({}, gamma);
      rig.light = std::exp2(stops);
      rig.run(12 * kSecond);
      EXPECT_LT(std::abs(rig.off()), 0.08) << gamma << ", " << stops;
      EXPECT_EQ(rig.run(60 * kSecond), 0) << gamma << ", " << stops << ": it pumps";
    }
  }
}

TEST(ExposureDrive, DoesNotOvershootWhenTheLightChanges) {
  for (const double gamma : {1.6, 2.2, 2.8}) {
    Rig rig({}, gamma);
    rig.run(12 * kSecond);
    rig.light = 4.0;
    double least = rig.mean;
    for (int i = 0; i < 10 * kSecond; ++i) {
      rig.step();
      least = std::min(least, rig.mean);
    }
    EXPECT_LT(std::abs(rig.off()), 0.08) << gamma;
    EXPECT_GT(least, 0.9 * rig.limits.brightness) << gamma;
  }
}

TEST(ExposureDrive, LetsSmallChangesOfLightBe) {
  Rig rig;
  rig.run(12 * kSecond);
  rig.light *= 1.06;
  EXPECT_EQ(rig.run(20 * kSecond), 0);
  rig.light *= 1.3;
  EXPECT_GT(rig.run(20 * kSecond), 0);
}

TEST(ExposureDrive, TakesGainOnlyWhereExposureIsAtItsEndAndKeepsToTheLimits) {
  Rig rig({.brightness = 0.45, .shortest_us = 100.0, .longest_us = 8000.0, .most_gain = 4.0});
  rig.light = 1.0;
  rig.run(12 * kSecond);
  EXPECT_NEAR(rig.drive.exposure().us, 4000.0, 800.0);
  EXPECT_EQ(rig.drive.exposure().gain, 1.0);
  rig.light = 0.25;
  rig.run(12 * kSecond);
  EXPECT_EQ(rig.drive.exposure().us, 8000.0);
  EXPECT_NEAR(rig.drive.exposure().gain, 2.0, 0.5);
  rig.light = 0.001;
  rig.run(20 * kSecond);
  EXPECT_EQ(rig.drive.exposure(), (Exposure{8000.0, 4.0}));
  EXPECT_EQ(rig.run(20 * kSecond), 0);
  rig.light = 1000.0;
  rig.run(20 * kSecond);
  EXPECT_NEAR(rig.drive.exposure().us, 100.0, 1e-9);
  EXPECT_EQ(rig.drive.exposure().gain, 1.0);
}

TEST(ExposureDrive, LooksOnlyAtPicturesThatCamerasSent) {
  Rig rig;
  for (int i = 0; i < 12 * kSecond; ++i) rig.step(0b101);  // the one between shows its slate, black
  EXPECT_LT(std::abs(rig.off()), 0.08);
  const Exposure before = rig.drive.exposure();
  rig.light = 4.0;
  for (int i = 0; i < 12 * kSecond; ++i) EXPECT_FALSE(rig.step(0));
  EXPECT_EQ(rig.drive.exposure(), before);
}

TEST(ExposureDrive, LooksOnlyAtTheTexelsThatCount) {
  std::vector<NativeBuffer> faces;
  faces.emplace_back(NativeLayout::kRgb24, YuvColour{}, kSize);
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      for (int c = 0; c < 3; ++c) *sample_at(faces[0].pixels(), c, x, y) = x < 40 ? 255 : 51;
    }
  }
  ExposureDrive drive({}, {{40, 0, 96, 64}});
  const std::vector<NativeImage> images = {as_const(faces[0].pixels())};
  drive.look(images, 1, 0ns);
  EXPECT_NEAR(drive.brightness(), 0.2, 1e-9);
}

}  // namespace
}  // namespace cupola
