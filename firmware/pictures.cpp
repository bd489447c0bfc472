// Drawing straight into RGB.
// SPDX-License-Identifier: MIT
#include "firmware/pictures.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace cupola {
namespace {

struct Cell {
  std::string_view view;
  int column;
  int row;
};
constexpr std::array<Cell, 6> kCross = {
    {{"top", 1, 0}, {"left", 0, 1}, {"front", 1, 1}, {"right", 2, 1}, {"back", 3, 1}, {"bottom", 1, 2}}};

// The cells of the views, moved to begin at (0, 0).
std::vector<Cell> cells_of(const Rig& rig) {
  std::vector<Cell> cells;
  int column = 0;
  for (const View& view : rig.views) {
    const auto* const found =
        std::find_if(kCross.begin(), kCross.end(), [&](const Cell& cell) { return cell.view == view.name; });
    if (found == kCross.end()) {
      cells.clear();
      for (const View& other : rig.views) cells.push_back({other.name, column++, 0});
      return cells;
    }
    cells.push_back(*found);
  }
  const auto left = std::min_element(cells.begin(), cells.end(), [](auto& a, auto& b) {
                      return a.column < b.column;
                    })->column;
  const auto top =
      std::min_element(cells.begin(), cells.end(), [](auto& a, auto& b) { return a.row < b.row; })->row;
  for (Cell& cell : cells) {
    cell.column -= left;
    cell.row -= top;
  }
  return cells;
}

}  // namespace

ImageBuffer unfolded(const Rig& rig, std::span<const Image> faces, std::span<const NeededRegion> needed) {
  const std::vector<Cell> cells = cells_of(rig);
  Size cell{};
  Size count{};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    cell = {std::max(cell.width, faces[i].size.width), std::max(cell.height, faces[i].size.height)};
    count = {std::max(count.width, cells[i].column + 1), std::max(count.height, cells[i].row + 1)};
  }
  ImageBuffer picture(PixelFormat::kRgb8, {cell.width * count.width, cell.height * count.height});
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Size size = faces[i].size;
    for (int y = 0; y < size.height; ++y) {
      auto* to = picture.pixels().samples<std::uint8_t>(0, cells[i].row * cell.height + y) +
                 std::ptrdiff_t{3} * cells[i].column * cell.width;
      const RowSpan row = needed[i].rows[static_cast<std::size_t>(y)];
      for (int plane = 0; plane < 3; ++plane) {
        const auto* from = faces[i].samples<std::uint8_t>(plane, y);
        for (int x = 0; x < size.width; ++x) {
          const bool bright = x >= row.first && x < row.last;
          to[3 * x + plane] = static_cast<std::uint8_t>(bright ? from[x] : from[x] / 5);
        }
      }
    }
  }
  return picture;
}

ImageBuffer coloured(const FrameMap& map) {
  using Colour = std::array<std::uint8_t, 3>;
  constexpr std::array<Colour, 6> kViews = {{{{240, 228, 66}},
                                             {{86, 180, 233}},
                                             {{0, 158, 115}},
                                             {{204, 121, 167}},
                                             {{230, 159, 0}},
                                             {{150, 150, 150}}}};
  ImageBuffer picture(PixelFormat::kRgb8, map.size);
  for (int y = 0; y < map.size.height; ++y) {
    auto* to = picture.pixels().samples<std::uint8_t>(0, y);
    for (int x = 0; x < map.size.width; ++x) {
      const std::uint8_t owner = map.at(x, y);
      Colour colour{};
      if (owner == FrameMap::kUncovered) colour = {213, 0, 0};
      if (owner < kViews.size()) colour = kViews[owner];
      std::copy(colour.begin(), colour.end(), to + std::ptrdiff_t{3} * x);
    }
  }
  return picture;
}

}  // namespace cupola
