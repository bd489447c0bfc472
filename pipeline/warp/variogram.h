// How unlike two points of a picture are, by their distance, and its means over texels: what the
// least-squares weights take a picture to be.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace cupola {

// Half the mean square difference of points d texels apart, as a share of the picture's variance, is
// (d / kPriorScale)^kPriorExponent. A power law looks the same at every scale, so that it does not matter how
// many texels a face has. The exponent is chosen, not fitted: photographs have about 0.2 (`cupola bench
// prior`), pictures of hard edges 1, and between 0.6 and 1 the results hardly differ (docs/performance.md).
// The scale only says what the rig's `noise` is a share of.
inline constexpr double kPriorExponent = 0.8;
inline constexpr double kPriorScale = 20.0;

// The power law's means over boxes one texel wide. const after construction; the same bits everywhere.
class Variogram {
 public:
  // Offsets of points from texel centres stay within this; both ways, texels.
  static constexpr int kReach = 12;

  explicit Variogram(double exponent);

  // Between all points of two texels `x` and `y` texels apart, 0 to kReach - 1.
  double between_texels(int x, int y) const;

  // Adds share * mean to sums[row * columns + column]: the mean between a point and all points of the texel
  // centred at (x + column, y + row) from it. `columns`: 4, 6, 8, 10 or 12.
  void add(double x, double y, int columns, int rows, double share, double* sums) const;

 private:
  static constexpr int kSteps = 16;  // a texel; linear between them
  static constexpr int kSide = 2 * kReach;

  template <int kColumns>
  void add_rows(double x, double y, int rows, double share, double* sums) const;
  const double* phase(int x, int y) const { return means_.data() + (y * (kSteps + 1) + x) * kSide * kSide; }
  double& mean(int x, int y, int column, int row) {
    return means_[((y * (kSteps + 1) + x) * kSide + row) * kSide + column];
  }

  // Phase by phase (a step apart both ways, both ends), within each a texel apart.
  std::vector<double> means_;
};

}  // namespace cupola
