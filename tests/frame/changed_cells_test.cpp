// The grid of changed cells against a set of texels.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/changed_cells.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <utility>

namespace cupola {
namespace {

TEST(ChangedCells, SayWhatASetOfCellsSays) {
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const auto upto = [&](int most) { return std::uniform_int_distribution<>(0, most)(random); };
    const Size size{1 + upto(5000), 1 + upto(300)};
    ChangedCells changed(size);
    std::set<std::pair<int, int>> cells;
    for (int k = upto(3); k > 0; --k) {
      const int x0 = upto(size.width + 40) - 40;
      const int y0 = upto(size.height + 40) - 40;
      const int x1 = x0 + upto(200);
      const int y1 = y0 + upto(80);
      changed.add(x0, y0, x1, y1);
      for (int y = std::max(0, y0); y < std::min(y1, size.height); ++y) {
        for (int x = std::max(0, x0); x < std::min(x1, size.width); ++x) cells.insert({x / 32, y / 32});
      }
    }
    ASSERT_EQ(changed.count(), static_cast<std::int64_t>(cells.size()));
    for (int k = 0; k < 20; ++k) {
      const int x0 = upto(size.width) - 10;
      const int y0 = upto(size.height) - 10;
      const int x1 = x0 + 1 + upto(100);
      const int y1 = y0 + 1 + upto(100);
      bool expected = false;
      for (const auto& [x, y] : cells) {
        expected = expected || (x * 32 < std::min(x1, size.width) && (x + 1) * 32 > x0 &&
                                y * 32 < std::min(y1, size.height) && (y + 1) * 32 > y0);
      }
      ASSERT_EQ(changed.touches(x0, y0, x1, y1), expected);
    }
  }
}

TEST(ChangedCells, AddUpAndAreCleared) {
  ChangedCells a({100, 100});
  ChangedCells b({100, 100});
  a.add(0, 0, 1, 1);
  b.add(99, 99, 100, 100);
  a.add(b);
  EXPECT_EQ(a.count(), 2);
  EXPECT_TRUE(a.touches(96, 96, 200, 200));
  EXPECT_FALSE(a.touches(32, 0, 96, 100));
  a.add_all();
  EXPECT_EQ(a.count(), a.cells());
  a.clear();
  EXPECT_EQ(a.count(), 0);
}

TEST(ChangedCells, OfNothingHaveNothing) {
  ChangedCells none;
  none.add(0, 0, 10, 10);
  EXPECT_FALSE(none.touches(0, 0, 10, 10));
  EXPECT_EQ(none.cells(), 0);
}

}  // namespace
}  // namespace cupola
