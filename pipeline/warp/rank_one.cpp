// Alternating least squares, which for one pair is power iteration.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/rank_one.h"

#include <algorithm>

namespace cupola {
namespace {

// Neighbouring footprints are nearly parallel: the second singular value is far below the first.
constexpr int kRounds = 12;

double dot(std::span<const double> x, std::span<const double> y) {
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += x[i] * y[i];
  return sum;
}

}  // namespace

void fit_rank_one(const DenseMatrix& w, std::size_t first, std::size_t last, RankOne& fit) {
  fit.a.assign(w.columns, 0.0);
  fit.b.assign(last - first, 0.0);
  fit.lost.assign(last - first, 0.0);
  fit.energy = 0.0;
  for (std::size_t p = first; p < last; ++p) {
    const std::span<const double> row = w.row(p);
    for (std::size_t u = 0; u < w.columns; ++u) fit.a[u] += row[u];
    fit.energy += dot(row, row);
  }
  double square = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0.0;
    for (const double each : fit.a) sum += each;
    for (double& each : fit.a) each /= sum;
    square = dot(fit.a, fit.a);
    for (std::size_t p = first; p < last; ++p) fit.b[p - first] = dot(w.row(p), fit.a) / square;
    // One row is its own best a; the last round leaves b fitted to the a that is returned.
    if (last - first == 1 || round + 1 == kRounds) break;
    std::fill(fit.a.begin(), fit.a.end(), 0.0);
    for (std::size_t p = first; p < last; ++p) {
      const std::span<const double> row = w.row(p);
      for (std::size_t u = 0; u < w.columns; ++u) fit.a[u] += fit.b[p - first] * row[u];
    }
  }
  fit.residual = 0.0;
  for (std::size_t p = first; p < last; ++p) {
    const double b = fit.b[p - first];
    fit.lost[p - first] = std::max(0.0, dot(w.row(p), w.row(p)) - b * b * square);
    fit.residual += fit.lost[p - first];
  }
}

}  // namespace cupola
