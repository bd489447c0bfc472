// Integrals over boxes as differences of one running integral.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/variogram.h"

#include <algorithm>
#include <cmath>

#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

// Integral of distance^exponent over the rectangle from (0, 0) to a node of a grid; odd in both coordinates.
class RunningIntegral {
 public:
  RunningIntegral(double exponent, int side, double step)
      : nodes_(side + 1), values_(static_cast<std::size_t>(nodes_ * nodes_)) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x <= y; ++x) {
        const double cell = over_cell(exponent, x * step, y * step, step);
        at(x + 1, y + 1) = cell;
        at(y + 1, x + 1) = cell;
      }
    }
    for (int y = 1; y < nodes_; ++y) {
      for (int x = 1; x < nodes_; ++x) at(x, y) += at(x - 1, y) + at(x, y - 1) - at(x - 1, y - 1);
    }
  }

  // Over the box of 2 * half steps a side about a node.
  double over_box(int x, int y, int half) const {
    return odd(x + half, y + half) - odd(x - half, y + half) - odd(x + half, y - half) +
           odd(x - half, y - half);
  }

 private:
  // Two points of Gauss each way: exact for cubics.
  static double over_cell(double exponent, double x, double y, double step) {
    const double low = (0.5 - 0.5 / std::sqrt(3.0)) * step;
    const double high = (0.5 + 0.5 / std::sqrt(3.0)) * step;
    double sum = 0.0;
    for (const double v : {y + low, y + high}) {
      for (const double u : {x + low, x + high}) sum += portable::power(u * u + v * v, exponent / 2.0);
    }
    return sum * 0.25 * step * step;
  }
  double& at(int x, int y) { return values_[static_cast<std::size_t>(y * nodes_ + x)]; }
  double odd(int x, int y) const {
    const double value = values_[static_cast<std::size_t>(std::abs(y) * nodes_ + std::abs(x))];
    return (x < 0) != (y < 0) ? -value : value;
  }

  int nodes_;
  std::vector<double> values_;
};

}  // namespace

Variogram::Variogram(double exponent) : means_((kSteps + 1) * (kSteps + 1) * kSide * kSide) {
  const RunningIntegral integral(exponent, (kReach + 1) * kSteps, 1.0 / kSteps);
  for (int y = 0; y <= kSteps; ++y) {
    for (int x = 0; x <= kSteps; ++x) {
      for (int row = 0; row < kSide; ++row) {
        for (int column = 0; column < kSide; ++column) {
          mean(x, y, column, row) =
              integral.over_box((column - kReach) * kSteps + x, (row - kReach) * kSteps + y, kSteps / 2);
        }
      }
    }
  }
}

double Variogram::between_texels(int x, int y) const {
  // The trapezoids' sum is the exact integral of what add() interpolates.
  double sum = 0.0;
  for (int v = -kSteps / 2; v <= kSteps / 2; ++v) {
    for (int u = -kSteps / 2; u <= kSteps / 2; ++u) {
      const double share = (std::abs(u) == kSteps / 2 ? 0.5 : 1.0) * (std::abs(v) == kSteps / 2 ? 0.5 : 1.0);
      const int column = x + kReach - (u < 0 ? 1 : 0);
      const int row = y + kReach - (v < 0 ? 1 : 0);
      sum += share * phase(u < 0 ? u + kSteps : u, v < 0 ? v + kSteps : v)[row * kSide + column];
    }
  }
  return sum / (kSteps * kSteps);
}

template <int kColumns>
void Variogram::add_rows(double x, double y, int rows, double share, double* __restrict sums) const {
  const double column = std::floor(x);
  const double row = std::floor(y);
  const double fine_x = (x - column) * kSteps;
  const double fine_y = (y - row) * kSteps;
  const int phase_x = std::min(static_cast<int>(fine_x), kSteps - 1);
  const int phase_y = std::min(static_cast<int>(fine_y), kSteps - 1);
  const double right = fine_x - phase_x;
  const double down = fine_y - phase_y;
  const double s00 = share * (1.0 - right) * (1.0 - down);
  const double s10 = share * right * (1.0 - down);
  const double s01 = share * (1.0 - right) * down;
  const double s11 = share * right * down;
  const auto first = static_cast<std::ptrdiff_t>((row + kReach) * kSide + column + kReach);
  const double* m00 = phase(phase_x, phase_y) + first;
  const double* m10 = phase(phase_x + 1, phase_y) + first;
  const double* m01 = phase(phase_x, phase_y + 1) + first;
  const double* m11 = phase(phase_x + 1, phase_y + 1) + first;
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < kColumns; ++u) {
      sums[u] = sums[u] + ((s00 * m00[u] + s10 * m10[u]) + (s01 * m01[u] + s11 * m11[u]));
    }
    sums += kColumns;
    m00 += kSide;
    m10 += kSide;
    m01 += kSide;
    m11 += kSide;
  }
}

void Variogram::add(double x, double y, int columns, int rows, double share, double* sums) const {
  switch (columns) {
    case 4:
      return add_rows<4>(x, y, rows, share, sums);
    case 6:
      return add_rows<6>(x, y, rows, share, sums);
    case 8:
      return add_rows<8>(x, y, rows, share, sums);
    case 10:
      return add_rows<10>(x, y, rows, share, sums);
    default:
      return add_rows<12>(x, y, rows, share, sums);
  }
}

}  // namespace cupola
