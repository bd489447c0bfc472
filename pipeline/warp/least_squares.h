// The weights that come nearest to a pixel's own integral: least squares over a window of texels.
//
// Of all weights with the sum 1 they minimise the expected square of sum(w_i t_i) - p, where p is the mean of
// the picture over the pixel's parallelogram and t_i its means over texels (one square texel each), with
// noise added. Means over areas a and b differ by what the variogram says, g(a, b), so that
//   sum_j (noise [i = j] - g(t_i, t_j)) w_j + m = -g(t_i, p),   sum_j w_j = 1.
// The matrix depends on the window's size alone and is inverted once; a pixel costs its right-hand side, a
// quadrature over the parallelogram, and one product of matrix and vector.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "pipeline/warp/pixel_area.h"
#include "pipeline/warp/variogram.h"

namespace cupola {

// const after construction; the same bits on every machine.
class LeastSquares {
 public:
  static constexpr int kLeastSide = 4;
  static constexpr int kMostSide = 12;
  static constexpr int kMostTexels = kMostSide * kMostSide;
  // Parallelograms whose box is larger than this a side are not for least squares.
  static constexpr double kMostExtent = 9.6;

  explicit LeastSquares(double noise);

  // The side of the window for a parallelogram whose box has this side: 4 up to 1.8 texels, then even numbers
  // from 2.4 texels more.
  static int side_for(double extent);

  // Weights of the window's texels, row by row. Sides are even, kLeastSide to kMostSide; the area's corners
  // and the window's lie within kReach - 1 of each other.
  void weigh(const PixelArea& area, const TexelWindow& window, double* weights) const;

 private:
  static constexpr int kSides = (kMostSide - kLeastSide) / 2 + 1;
  static constexpr int kMostPoints = 16;

  // weights = constant - matrix * g(t, p), the matrix symmetric.
  struct Solution {
    std::vector<double> matrix;
    std::vector<double> constant;
  };
  struct Rule {
    std::vector<double> at;     // -1/2 to 1/2
    std::vector<double> share;  // sum 1
  };

  Solution solve(double noise, int width, int height) const;

  Variogram variogram_;
  std::array<Solution, kSides * kSides> solutions_;
  std::array<Rule, kMostPoints + 1> rules_;  // by number of points
};

}  // namespace cupola
