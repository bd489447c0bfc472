// Inverts once for every size of window; quadrature by Gauss for every pixel.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/least_squares.h"

#include <algorithm>
#include <cmath>

#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

// Solves a x = b for `columns` right-hand sides at once, in place: Gauss and Jordan with row pivots. Row i of
// `rows` is a's row followed by b's.
void eliminate(std::vector<double>& rows, int count, int columns) {
  const int stride = count + columns;
  for (int k = 0; k < count; ++k) {
    int best = k;
    for (int i = k + 1; i < count; ++i) {
      if (std::abs(rows[i * stride + k]) > std::abs(rows[best * stride + k])) best = i;
    }
    if (best != k) {
      std::swap_ranges(rows.begin() + k * stride, rows.begin() + (k + 1) * stride,
                       rows.begin() + best * stride);
    }
    double* pivot = rows.data() + k * stride;
    const double scale = 1.0 / pivot[k];
    for (int j = k; j < stride; ++j) pivot[j] *= scale;
    for (int i = 0; i < count; ++i) {
      double* row = rows.data() + i * stride;
      const double factor = row[k];
      if (i == k || factor == 0.0) continue;
      for (int j = k; j < stride; ++j) row[j] -= factor * pivot[j];
    }
  }
}

// Roots of the Legendre polynomial of degree n by Newton's method, and their shares.
void gauss_legendre(int n, std::vector<double>& at, std::vector<double>& share) {
  for (int i = 0; i < n; ++i) {
    double x = portable::sine_cosine(portable::kPi * (i + 0.75) / (n + 0.5)).cosine;
    double slope = 0.0;
    for (int step = 0; step < 8; ++step) {
      double before = 1.0;
      double here = x;
      for (int k = 2; k <= n; ++k) {
        const double next = ((2.0 * k - 1.0) * x * here - (k - 1.0) * before) / k;
        before = here;
        here = next;
      }
      slope = n * (x * here - before) / (x * x - 1.0);
      x -= here / slope;
    }
    at.push_back(x / 2.0);
    share.push_back(1.0 / ((1.0 - x * x) * slope * slope));
  }
}

// Enough that weights err by 1e-3 in all, root mean square over a footprint's weights.
int points_for(double u, double v) {
  return static_cast<int>(2.3 + 2.0 * std::sqrt(u * u + v * v));
}

}  // namespace

LeastSquares::LeastSquares(double noise) : variogram_(kPriorExponent) {
  const double noise_in_power = noise * portable::power(kPriorScale, kPriorExponent);
  for (int height = kLeastSide; height <= kMostSide; height += 2) {
    for (int width = kLeastSide; width <= kMostSide; width += 2) {
      solutions_[(height - kLeastSide) / 2 * kSides + (width - kLeastSide) / 2] =
          solve(noise_in_power, width, height);
    }
  }
  for (int n = 2; n <= kMostPoints; ++n) gauss_legendre(n, rules_[n].at, rules_[n].share);
}

LeastSquares::Solution LeastSquares::solve(double noise, int width, int height) const {
  const int texels = width * height;
  const int count = texels + 1;
  const int stride = 2 * count;
  std::array<double, kMostSide * kMostSide> between;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) between[y * kMostSide + x] = variogram_.between_texels(x, y);
  }
  std::vector<double> rows(static_cast<std::size_t>(count * stride));
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      double& entry = rows[i * stride + j];
      if (i == texels || j == texels) {
        entry = i == j ? 0.0 : 1.0;
      } else {
        entry = -between[std::abs(i / width - j / width) * kMostSide + std::abs(i % width - j % width)];
        if (i == j) entry += noise;
      }
    }
    rows[i * stride + count + i] = 1.0;
  }
  eliminate(rows, count, count);
  Solution solution;
  for (int i = 0; i < texels; ++i) {
    const double* inverse = rows.data() + i * stride + count;
    solution.matrix.insert(solution.matrix.end(), inverse, inverse + texels);
    solution.constant.push_back(inverse[texels]);
  }
  return solution;
}

int LeastSquares::side_for(double extent) {
  if (extent <= 1.8) return kLeastSide;
  return std::min(kMostSide, 2 * static_cast<int>(std::ceil((extent + 2.4) / 2.0)));
}

void LeastSquares::weigh(const PixelArea& area, const TexelWindow& window, double* weights) const {
  const int texels = window.width * window.height;
  std::array<double, kMostTexels> unlike;
  std::fill_n(unlike.begin(), texels, 0.0);
  const Rule& across = rules_[std::min(kMostPoints, points_for(area.ux, area.vx))];
  const Rule& downward = rules_[std::min(kMostPoints, points_for(area.uy, area.vy))];
  for (std::size_t b = 0; b < downward.at.size(); ++b) {
    for (std::size_t a = 0; a < across.at.size(); ++a) {
      const double u = area.u + (area.ux * across.at[a] + area.uy * downward.at[b]);
      const double v = area.v + (area.vx * across.at[a] + area.vy * downward.at[b]);
      variogram_.add(window.x + 0.5 - u, window.y + 0.5 - v, window.width, window.height,
                     across.share[a] * downward.share[b], unlike.data());
    }
  }
  const Solution& solution =
      solutions_[(window.height - kLeastSide) / 2 * kSides + (window.width - kLeastSide) / 2];
  std::copy_n(solution.constant.begin(), texels, weights);
  for (int k = 0; k < texels; ++k) {
    const double* column = solution.matrix.data() + static_cast<std::ptrdiff_t>(k) * texels;
    const double factor = unlike[k];
    for (int i = 0; i < texels; ++i) weights[i] -= factor * column[i];
  }
}

}  // namespace cupola
