// Which parts of a face differ from the face before: a grid of cells of 32 x 32 texels, one bit each.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/frame/image.h"

namespace cupola {

// May say too much, never too little. Allocates when made or copied, not afterwards.
class ChangedCells {
 public:
  static constexpr int kSide = 32;  // texels

  ChangedCells() = default;
  explicit ChangedCells(Size size);  // of the face; nothing changed

  Size size() const { return size_; }
  void clear();
  void add_all();
  // Texels [x0, x1) x [y0, y1), which may reach beyond the face.
  void add(int x0, int y0, int x1, int y1);
  void add(const ChangedCells& other);  // of the same size
  bool touches(int x0, int y0, int x1, int y1) const;
  // Cells that changed, and all there are.
  std::int64_t count() const;
  std::int64_t cells() const { return std::int64_t{across_} * down_; }

 private:
  struct Cells {
    int x0, y0, x1, y1;
    bool empty() const { return x0 >= x1 || y0 >= y1; }
  };
  Cells cells_of(int x0, int y0, int x1, int y1) const;
  // Bits [first, last) of the word that holds bits 64 * word and on.
  static std::uint64_t bits(int word, int first, int last);

  Size size_;
  int across_ = 0;
  int down_ = 0;
  int words_ = 0;  // a row of cells
  std::vector<std::uint64_t> changed_;
};

}  // namespace cupola
