// Sinc under a Kaiser window, in a table.
// SPDX-License-Identifier: MIT
#include "pipeline/sound/fine_resampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace cupola {

namespace {

constexpr double kBeta = 9.0;

double bessel0(double x) {
  double sum = 1.0;
  double term = 1.0;
  for (int k = 1; k < 60; ++k) {
    term *= (x / (2.0 * k)) * (x / (2.0 * k));
    sum += term;
  }
  return sum;
}

double kernel(double x) {
  constexpr double kHalf = FineResampler::kTaps / 2.0;
  if (std::abs(x) >= kHalf) return 0.0;
  const double window = bessel0(kBeta * std::sqrt(1.0 - (x / kHalf) * (x / kHalf))) / bessel0(kBeta);
  const double angle = std::numbers::pi * x;
  return window * (x == 0.0 ? 1.0 : std::sin(angle) / angle);
}

}  // namespace

FineResampler::FineResampler() : weights_((kPhases + 1) * kTaps) {
  for (int phase = 0; phase <= kPhases; ++phase) {
    std::array<double, kTaps> row{};
    double sum = 0.0;
    for (int tap = 0; tap < kTaps; ++tap) {
      // At whole frames the sinc is 0 but for one tap: rounding must not say otherwise.
      const double x = tap - kBefore - static_cast<double>(phase) / kPhases;
      const bool whole = phase % kPhases == 0;
      row[static_cast<std::size_t>(tap)] = whole ? (x == 0.0 ? 1.0 : 0.0) : kernel(x);
      sum += row[static_cast<std::size_t>(tap)];
    }
    for (int tap = 0; tap < kTaps; ++tap) {
      weights_[static_cast<std::size_t>(phase * kTaps + tap)] =
          static_cast<float>(row[static_cast<std::size_t>(tap)] / sum);
    }
  }
}

void FineResampler::between(std::span<const float> frames, double fraction,
                            std::span<float> out) const noexcept {
  const double place = fraction * kPhases;
  const int phase = std::min(static_cast<int>(place), kPhases - 1);
  const auto part = static_cast<float>(place - phase);
  const float* first = weights_.data() + static_cast<std::ptrdiff_t>(phase) * kTaps;
  const float* second = first + kTaps;
  std::array<float, kTaps> weights;
  for (std::size_t tap = 0; tap < kTaps; ++tap) weights[tap] = first[tap] + part * (second[tap] - first[tap]);
  const std::size_t channels = out.size();
  for (std::size_t channel = 0; channel < channels; ++channel) {
    float sum = 0.0F;
    for (std::size_t tap = 0; tap < kTaps; ++tap) sum += weights[tap] * frames[tap * channels + channel];
    out[channel] = sum;
  }
}

}  // namespace cupola
