// The best product of a column and a row for a matrix, in the sense of least squares.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace cupola {

// Entries w(p, u) >= 0, row by row, none of the rows all 0.
struct DenseMatrix {
  std::size_t rows = 0, columns = 0;
  std::vector<double> entries;
  std::span<const double> row(std::size_t p) const { return {entries.data() + p * columns, columns}; }
};

// w(p, u) ~ b(p) a(u), a and b >= 0, a with the sum 1.
struct RankOne {
  std::vector<double> a, b;
  std::vector<double> lost;  // sum of (w - b a)^2 of each row
  double energy = 0.0;       // sum of w^2 over the rows looked at
  double residual = 0.0;     // sum of `lost`
};

// Of rows [first, last): the leading pair of singular vectors, by power iteration from the column sums.
void fit_rank_one(const DenseMatrix& w, std::size_t first, std::size_t last, RankOne& fit);

}  // namespace cupola
