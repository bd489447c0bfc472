// A variogram over all photographs, and the power law nearest to it.
// SPDX-License-Identifier: MIT
#include "firmware/bench_prior.h"

#include <array>
#include <cmath>

#include "pipeline/frame/still.h"
#include "pipeline/warp/variogram.h"

namespace cupola {
namespace {

constexpr std::array<int, 8> kDistances = {1, 2, 3, 4, 5, 6, 8, 10};

// Mean square differences of a picture's green at the distances.
std::array<double, kDistances.size()> differences(const std::filesystem::path& file) {
  const ImageBuffer read = read_still(file);
  ImageBuffer picture(PixelFormat::kRgbPlanar8, read.pixels().size);
  convert(read.pixels(), picture.pixels());
  const Image image = as_const(picture.pixels());
  std::array<double, kDistances.size()> mean{};
  for (std::size_t i = 0; i < kDistances.size(); ++i) {
    const int distance = kDistances[i];
    double sum = 0.0;
    double pairs = 0.0;
    for (int y = 0; y + distance < image.size.height; ++y) {
      const std::uint8_t* row = image.samples<std::uint8_t>(1, y);
      const std::uint8_t* below = image.samples<std::uint8_t>(1, y + distance);
      for (int x = 0; x + distance < image.size.width; ++x) {
        for (const int other : {row[x + distance], below[x]}) {
          if (row[x] == 0 || other == 0) continue;
          sum += (row[x] - other) * (row[x] - other);
          pairs += 1.0;
        }
      }
    }
    mean[i] = pairs > 0.0 ? sum / pairs : 0.0;
  }
  return mean;
}

}  // namespace

PriorFit fit_prior(const std::vector<std::filesystem::path>& photographs) {
  std::array<double, kDistances.size()> logarithm{};
  for (const std::filesystem::path& file : photographs) {
    const auto mean = differences(file);
    for (std::size_t i = 0; i < kDistances.size(); ++i) {
      logarithm[i] += std::log(mean[i] / mean[0]) / static_cast<double>(photographs.size());
    }
  }
  PriorFit best;
  double least = HUGE_VAL;
  for (int hundredths = 10; hundredths <= 180; hundredths += 2) {
    const Variogram variogram(hundredths / 100.0);
    const auto beyond_own = [&](int distance) {
      return variogram.between_texels(distance, 0) - variogram.between_texels(0, 0);
    };
    PriorFit fit{hundredths / 100.0, {}};
    double squares = 0.0;
    for (std::size_t i = 0; i < kDistances.size(); ++i) {
      const double fitted = beyond_own(kDistances[i]) / beyond_own(1);
      squares += (std::log(fitted) - logarithm[i]) * (std::log(fitted) - logarithm[i]);
      fit.distances.push_back({kDistances[i], std::exp(logarithm[i]), fitted});
    }
    if (squares < least) {
      least = squares;
      best = fit;
    }
  }
  return best;
}

}  // namespace cupola
