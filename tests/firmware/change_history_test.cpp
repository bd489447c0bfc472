// The history of changes: buffers of any age get all that they miss.
// SPDX-License-Identifier: MIT
#include "firmware/change_history.h"

#include <gtest/gtest.h>

#include <random>

namespace cupola {
namespace {

constexpr Size kFace{64, 64};  // four cells

std::vector<ChangedCells> one_cell(int cell) {
  std::vector<ChangedCells> changed(1, ChangedCells(kFace));
  changed[0].add(cell % 2 * 32, cell / 2 * 32, cell % 2 * 32 + 1, cell / 2 * 32 + 1);
  return changed;
}

TEST(ChangeHistory, GivesAllThatABufferOfItsAgeMisses) {
  ChangeHistory history(std::vector<Size>{kFace});
  EXPECT_TRUE(history.take(0).empty()) << "anything may differ in the first frame";
  for (int i = 0; i < 12; ++i) {
    history.fetched(one_cell(i % 4));
    const int age = 1 + i % 3;
    const auto changed = history.take(age);
    if (i + 1 < age) {
      EXPECT_TRUE(changed.empty()) << "older than all that is known";
    } else {
      ASSERT_EQ(changed.size(), 1U);
      EXPECT_EQ(changed[0].count(), age);
    }
  }
}

TEST(ChangeHistory, AddsUpFetchesThatWereNotWarped) {
  ChangeHistory history(std::vector<Size>{kFace});
  history.take(0);
  history.fetched(one_cell(0));
  history.fetched(one_cell(3));
  EXPECT_EQ(history.take(1)[0].count(), 2);
  EXPECT_EQ(history.take(1)[0].count(), 0);
}

TEST(ChangeHistory, DoesNotKnowWhatItWasNotTold) {
  ChangeHistory history(std::vector<Size>{kFace});
  history.take(0);
  history.fetched({});
  EXPECT_TRUE(history.take(1).empty());
  history.fetched(one_cell(1));
  EXPECT_TRUE(history.take(2).empty()) << "it was not told of the frame between";
  history.fetched(one_cell(1));
  EXPECT_EQ(history.take(1).size(), 1U);
  EXPECT_TRUE(history.take(ChangeHistory::kFrames + 1).empty());
  EXPECT_TRUE(history.take(0).empty());
}

}  // namespace
}  // namespace cupola
