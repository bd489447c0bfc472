// Which cells of a face are of one colour: what reaches into such cells alone need not be filtered.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/frame/changed_cells.h"
#include "pipeline/frame/image.h"
#include "pipeline/optics/needed_region.h"

namespace cupola {

// A texel's samples, of 8 or 16 bits as the faces have them.
struct Colour {
  std::uint16_t r = 0, g = 0, b = 0;
  friend bool operator==(const Colour&, const Colour&) = default;
};

// The cells are those of ChangedCells. Texels that are not needed have no say. Allocates when made or copied,
// not afterwards.
class EvenCells {
 public:
  EvenCells() = default;
  explicit EvenCells(Size size);  // of the face; no cell is known to be even

  // Looks at the needed texels of the cells in `changed`, which have changed since the last look, or of all
  // where it is null. A cell that is not even is mostly left at its first row. `face` is planar; `needed` is
  // the same every time.
  void look(const Image& face, const NeededRegion& needed, const ChangedCells* changed);
  // Whether the needed texels of all cells that texels [x0, x1) x [y0, y1) lie in are of one colour, that of
  // `one` if it has one already; gives `one` that colour. True where no texel is needed.
  bool agree(int x0, int y0, int x1, int y1, std::optional<Colour>& one) const;
  std::int64_t count() const;  // even cells

 private:
  enum class Kind : std::uint8_t { kUneven, kUnused, kEven };
  struct Cell {
    Kind kind = Kind::kUneven;
    Colour colour;
  };
  template <class Sample>
  Cell look_at(const Image& face, const NeededRegion& needed, int x0, int y0) const;

  Size size_;
  int across_ = 0;
  int down_ = 0;
  std::vector<Cell> cells_;
};

}  // namespace cupola
