// The fine resampler against the sine that it resamples.
// SPDX-License-Identifier: MIT
#include "pipeline/sound/fine_resampler.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace cupola {
namespace {

// How far below a sine of `hertz`, of 48,000 frames a second, the worst of what it makes wrong lies.
double error_db(double hertz) {
  const FineResampler resampler;
  std::array<float, FineResampler::kTaps> frames{};
  double worst = 0.0;
  const double step = 2.0 * std::numbers::pi * hertz / 48000.0;
  for (int place = 0; place < 2000; ++place) {
    const double fraction = std::fmod(place * 0.61803398875, 1.0);
    for (int tap = 0; tap < FineResampler::kTaps; ++tap)
      frames[static_cast<std::size_t>(tap)] = static_cast<float>(std::sin(step * (place + tap)));
    float made = 0.0F;
    resampler.between(frames, fraction, {&made, 1});
    worst = std::max(worst, std::abs(made - std::sin(step * (place + FineResampler::kBefore + fraction))));
  }
  return 20.0 * std::log10(worst);
}

TEST(FineResampler, MakesOfASineTheSineBetweenItsFrames) {
  EXPECT_LT(error_db(100.0), -95.0);
  EXPECT_LT(error_db(1000.0), -95.0);
  EXPECT_LT(error_db(10000.0), -90.0);
  EXPECT_LT(error_db(16000.0), -80.0);
}

TEST(FineResampler, GivesAFrameItselfToTheBit) {
  const FineResampler resampler;
  std::array<float, 2 * FineResampler::kTaps> frames{};
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i] = 0.37F * std::sin(static_cast<float>(i * i));
  std::array<float, 2> made{};
  resampler.between(frames, 0.0, made);
  EXPECT_EQ(made[0], frames[2 * FineResampler::kBefore]);
  EXPECT_EQ(made[1], frames[2 * FineResampler::kBefore + 1]);
}

}  // namespace
}  // namespace cupola
