// The printed board: a chessboard whose inner corners are found in pictures.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/optics/vector.h"

namespace cupola {

// Corners are counted where four squares meet: a board of 10 x 7 squares has 9 x 6. One count is even and the
// other odd: only then does the board look different upside down, so that every camera names its corners
// alike.
struct Board {
  int columns = 9;
  int rows = 6;
  double square_m = 0.025;

  int corners() const { return columns * rows; }
};

// "9x6"; throws InputError.
Board parse_board(const std::string& size, double square_mm);

// Row by row, in metres: x along a row, y from row to row, z = 0, about the board's middle.
std::vector<Vec3> board_corners(const Board& board);

}  // namespace cupola
