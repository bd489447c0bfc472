// Symmetric positive definite systems, dense, by rows: `matrix` is size x size.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

namespace cupola {

// Only the lower triangle is read; it becomes the factor L of L L^T. False when it is not positive definite.
bool factorise(std::span<double> matrix, std::size_t size);

// `values` become the solution, by a factor from above.
void solve(std::span<const double> factor, std::size_t size, std::span<double> values);

// A factor becomes the whole inverse. Allocates, unlike the others.
void invert(std::span<double> factor, std::size_t size);

}  // namespace cupola
