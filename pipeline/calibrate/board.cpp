// Reading a board's size, and where its corners are.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/board.h"

#include <fmt/format.h>

#include <cstdio>

#include "pipeline/frame/error.h"

namespace cupola {

Board parse_board(const std::string& size, double square_mm) {
  Board board;
  char rest = 0;
  if (std::sscanf(size.c_str(), "%3dx%3d%c", &board.columns, &board.rows, &rest) != 2 || board.columns < 3 ||
      board.rows < 3 || board.columns > 50 || board.rows > 50) {
    throw InputError(fmt::format(
        "--board {}: expected inner corners as COLUMNSxROWS, from 3 to 50 each, as in 9x6", size));
  }
  if (board.columns % 2 == board.rows % 2) {
    throw InputError(fmt::format(
        "--board {}: expected an even and an odd number: this board looks the same upside down, so that "
        "cameras could not agree which corner is which",
        size));
  }
  if (!(square_mm >= 0.1 && square_mm <= 10'000.0)) {
    throw InputError(fmt::format("--square-mm {}: expected millimetres from 0.1 to 10000", square_mm));
  }
  board.square_m = square_mm / 1000.0;
  return board;
}

std::vector<Vec3> board_corners(const Board& board) {
  std::vector<Vec3> corners;
  for (int y = 0; y < board.rows; ++y) {
    for (int x = 0; x < board.columns; ++x) {
      corners.emplace_back((x - (board.columns - 1) / 2.0) * board.square_m,
                           (y - (board.rows - 1) / 2.0) * board.square_m, 0.0);
    }
  }
  return corners;
}

}  // namespace cupola
