// What becomes of a view's colours on their way into the frame, so that several sensors make one picture.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>

namespace cupola {

// gain x + offset of each sample of R, G and B, in 8-bit steps as they are encoded: of a power law a gain of
// light is a gain of samples.
struct ViewColour {
  static constexpr double kLeastGain = 0.5;
  static constexpr double kMostGain = 1.8;  // the conversion's coefficients fit 16 bits, see yuv_rows.h
  static constexpr double kMostOffset = 64.0;

  std::array<double, 3> gain{1.0, 1.0, 1.0};
  std::array<double, 3> offset{0.0, 0.0, 0.0};
  double of(std::size_t channel, double sample) const { return gain[channel] * sample + offset[channel]; }
  friend bool operator==(const ViewColour&, const ViewColour&) = default;
};

}  // namespace cupola
