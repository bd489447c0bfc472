// Cholesky's factor, forward and back.
// SPDX-License-Identifier: MIT
#include "pipeline/portable/cholesky.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace cupola {

bool factorise(std::span<double> matrix, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    double* row = &matrix[i * size];
    for (std::size_t j = 0; j <= i; ++j) {
      const double* other = &matrix[j * size];
      const double rest = row[j] - std::inner_product(row, row + j, other, 0.0);
      if (j < i) {
        row[j] = rest / other[j];
      } else {
        // What cancels to nearly nothing is not determined by anything that was seen.
        if (!(rest > 1e-14 * row[i])) return false;
        row[i] = std::sqrt(rest);
      }
    }
  }
  return true;
}

void solve(std::span<const double> factor, std::size_t size, std::span<double> values) {
  for (std::size_t i = 0; i < size; ++i) {
    const double* row = &factor[i * size];
    values[i] = (values[i] - std::inner_product(row, row + i, values.begin(), 0.0)) / row[i];
  }
  for (std::size_t i = size; i-- > 0;) {
    values[i] /= factor[i * size + i];
    for (std::size_t j = 0; j < i; ++j) values[j] -= factor[i * size + j] * values[i];
  }
}

void invert(std::span<double> factor, std::size_t size) {
  std::vector<double> whole(size * size);
  std::vector<double> column(size);
  for (std::size_t i = 0; i < size; ++i) {
    column.assign(size, 0.0);
    column[i] = 1.0;
    solve(factor, size, column);
    for (std::size_t j = 0; j < size; ++j) whole[i * size + j] = column[j];
  }
  std::copy(whole.begin(), whole.end(), factor.begin());
}

}  // namespace cupola
