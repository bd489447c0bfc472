// What comparing faces finds: every edit, in the cells where it is, and nothing where there is none.
// SPDX-License-Identifier: MIT
#include "pipeline/source/face_changes.h"

#include <gtest/gtest.h>

#include <random>

namespace cupola {
namespace {

struct Case {
  Size size;
  PixelFormat format;
};

class FaceChanges : public testing::TestWithParam<Case> {
 protected:
  FaceChanges() {
    for (ImageBuffer* face : {&before_, &now_}) {
      *face = ImageBuffer(GetParam().format, GetParam().size);
      std::mt19937 same(3);
      for (int plane = 0; plane < 3; ++plane) {
        for (int y = 0; y < size_.height; ++y) {
          for (int x = 0; x < bytes_; ++x) face->pixels().planes[plane].row(y)[x] = std::byte(same());
        }
      }
    }
  }
  ChangedCells found(const NeededRegion& needed) const {
    ChangedCells changed(size_);
    add_changes(before_.pixels(), now_.pixels(), needed, changed);
    return changed;
  }

  const Size size_ = GetParam().size;
  const int sample_ = sample_bytes(GetParam().format);
  const int bytes_ = size_.width * sample_;
  ImageBuffer before_, now_;
};

TEST_P(FaceChanges, AreNoneBetweenEqualFaces) {
  EXPECT_EQ(found(NeededRegion::all(size_)).count(), 0);
}

TEST_P(FaceChanges, AreTheCellsOfEveryChangedBit) {
  std::mt19937 random(11);
  for (int round = 0; round < 500; ++round) {
    ChangedCells expected(size_);
    struct Edit {
      int plane, x, y;
      std::byte bit;
    };
    std::vector<Edit> edits(1 + random() % 5);
    for (Edit& edit : edits) {
      edit = {static_cast<int>(random() % 3), static_cast<int>(random() % static_cast<unsigned>(bytes_)),
              static_cast<int>(random() % static_cast<unsigned>(size_.height)),
              std::byte(1U << random() % 8)};
      now_.pixels().planes[static_cast<std::size_t>(edit.plane)].row(edit.y)[edit.x] ^= edit.bit;
    }
    for (const Edit& edit : edits) {
      const auto plane = static_cast<std::size_t>(edit.plane);
      if (before_.pixels().planes[plane].row(edit.y)[edit.x] ==
          now_.pixels().planes[plane].row(edit.y)[edit.x])
        continue;  // the same bit twice
      expected.add(edit.x / sample_, edit.y, edit.x / sample_ + 1, edit.y + 1);
    }
    const ChangedCells changed = found(NeededRegion::all(size_));
    ASSERT_EQ(changed.count(), expected.count()) << round;
    for (const Edit& edit : edits) {
      const int x = edit.x / sample_;
      ASSERT_EQ(changed.touches(x, edit.y, x + 1, edit.y + 1),
                expected.touches(x, edit.y, x + 1, edit.y + 1));
      const auto plane = static_cast<std::size_t>(edit.plane);
      now_.pixels().planes[plane].row(edit.y)[edit.x] = before_.pixels().planes[plane].row(edit.y)[edit.x];
    }
  }
}

TEST_P(FaceChanges, DoNotCountWhereNothingIsNeeded) {
  NeededRegion needed = NeededRegion::none(size_);
  const int x = size_.width - 1;
  const int y = size_.height - 1;
  now_.pixels().planes[2].row(y)[x * sample_] ^= std::byte{1};
  EXPECT_EQ(found(needed).count(), 0);
  needed.include(x, y);
  EXPECT_EQ(found(needed).count(), 1);
  EXPECT_TRUE(found(needed).touches(x, y, x + 1, y + 1));
}

INSTANTIATE_TEST_SUITE_P(
    Sizes, FaceChanges,
    testing::Values(Case{{1, 1}, PixelFormat::kRgbPlanar8}, Case{{1, 1}, PixelFormat::kRgbPlanar16},
                    Case{{150, 141}, PixelFormat::kRgbPlanar8}, Case{{97, 64}, PixelFormat::kRgbPlanar16},
                    Case{{2100, 70}, PixelFormat::kRgbPlanar8}, Case{{4096, 33}, PixelFormat::kRgbPlanar16}));

}  // namespace
}  // namespace cupola
