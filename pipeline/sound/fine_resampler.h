// A stream of sound played a little faster or slower than it was made, to keep it in step.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace cupola {

// Weighs `kTaps` frames around a place between two of them with a windowed sinc. At a whole frame that is the
// frame itself, to the bit: a step of exactly 1 changes nothing.
class FineResampler {
 public:
  static constexpr int kTaps = 32;
  static constexpr int kBefore = kTaps / 2 - 1;  // frames needed before the place; the rest lies after it

  FineResampler();
  // The frame at `fraction`, from 0 to below 1, after frame kBefore of `frames`: kTaps frames of
  // `out.size()` samples each.
  void between(std::span<const float> frames, double fraction, std::span<float> out) const noexcept;

 private:
  static constexpr int kPhases = 512;  // between them the weights are interpolated
  std::vector<float> weights_;         // kPhases + 1 rows of kTaps; the sums are 1
};

}  // namespace cupola
