// Corners counted by ninths of the picture.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/coverage.h"

#include <algorithm>
#include <array>

namespace cupola {

std::vector<std::string> parts_without_board(std::span<const Sighting* const> sightings, Size size) {
  std::array<std::array<bool, 3>, 3> seen{};  // [row][column]
  const auto third = [](double at, int side) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(3.0 * at / side), 0, 2));
  };
  for (const Sighting* sighting : sightings) {
    for (const Vec2& at : sighting->corners) seen[third(at.y, size.height)][third(at.x, size.width)] = true;
  }
  constexpr std::array<const char*, 3> kColumns = {"left", "middle", "right"};
  constexpr std::array<const char*, 3> kRows = {"upper", "middle", "lower"};
  std::vector<std::string> parts;
  std::array<bool, 3> whole_column{};
  for (std::size_t x = 0; x < 3; ++x) {
    whole_column[x] = !seen[0][x] && !seen[1][x] && !seen[2][x];
    if (whole_column[x]) parts.push_back("the " + std::string(kColumns[x]) + " third");
  }
  for (std::size_t y = 0; y < 3; ++y) {
    if (!seen[y][0] && !seen[y][1] && !seen[y][2]) {
      parts.push_back("the " + std::string(kRows[y]) + " third");
      continue;
    }
    for (std::size_t x = 0; x < 3; ++x) {
      if (seen[y][x] || whole_column[x]) continue;
      if (x == 1 && y == 1) {
        parts.emplace_back("the middle");
      } else if (x == 1) {
        parts.push_back(std::string("the ") + kRows[y] + " edge");
      } else if (y == 1) {
        parts.push_back(std::string("the ") + kColumns[x] + " edge");
      } else {
        parts.push_back(std::string("the ") + kRows[y] + " " + kColumns[x] + " corner");
      }
    }
  }
  return parts;
}

}  // namespace cupola
