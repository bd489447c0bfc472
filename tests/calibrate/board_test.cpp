// Boards: their sizes as they are given, and finding them in pictures.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/board.h"

#include <gmock/gmock.h>

#include <cmath>

#include "pipeline/calibrate/coverage.h"
#include "pipeline/calibrate/opencv.h"
#include "pipeline/frame/error.h"
#include "pipeline/frame/still.h"
#include "tests/calibrate/simulated_rig.h"

namespace cupola {
namespace {

constexpr Size kSize{600, 600};

std::string refusal(const std::string& size, double square_mm = 25.0) {
  try {
    parse_board(size, square_mm);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Board, IsReadFromItsInnerCorners) {
  const Board board = parse_board("9x6", 30.0);
  EXPECT_EQ(board.columns, 9);
  EXPECT_EQ(board.rows, 6);
  EXPECT_DOUBLE_EQ(board.square_m, 0.03);
  EXPECT_THAT(refusal("9"), testing::HasSubstr("expected inner corners as COLUMNSxROWS"));
  EXPECT_THAT(refusal("9x6x"), testing::HasSubstr("expected inner corners"));
  EXPECT_THAT(refusal("2x5"), testing::HasSubstr("from 3 to 50"));
  EXPECT_THAT(refusal("8x6"), testing::HasSubstr("looks the same upside down"));
  EXPECT_THAT(refusal("9x6", 0.0), testing::HasSubstr("--square-mm 0: expected"));
}

TEST(Coverage, NamesThePartsOfThePictureThatNoBoardWasIn) {
  Sighting sighting;
  const auto parts = [&](std::vector<Vec2> corners) {
    sighting.corners = std::move(corners);
    const Sighting* const one = &sighting;
    return parts_without_board({&one, 1}, {300, 300});
  };
  using testing::ElementsAre;
  EXPECT_THAT(parts({{150, 50}, {250, 50}, {150, 150}, {250, 150}, {150, 250}, {250, 250}}),
              ElementsAre("the left third"));
  EXPECT_THAT(parts({{50, 50}, {150, 50}, {250, 50}, {50, 150}, {150, 150}, {250, 150}}),
              ElementsAre("the lower third"));
  EXPECT_THAT(parts({{150, 50}, {250, 50}, {50, 150}, {250, 150}, {50, 250}, {150, 250}, {250, 250}}),
              ElementsAre("the upper left corner", "the middle"));
}

// Squares of 10 texels, noise of 2 steps, and the lens's bending within them: 0.04 to 0.14 texels, and no
// bias.
TEST(FindBoard, FindsCornersWhereTheyAreAndNamesThemAlikeHoweverTheBoardIsTurned) {
  if (!have_opencv()) GTEST_SKIP() << "built without OpenCV";
  const Board board;
  const SimulatedCamera camera = simulated_cameras(kSize)[0];
  const Photographer photographer(camera);
  for (int quarter = 0; quarter < 8; ++quarter) {
    Pose pose = simulated_shots({camera}, board, quarter + 1, 0).back().board;
    pose.turn = pose.turn * turn_about({0, 0, quarter * 0.785});
    const std::optional<Sighting> truth = exact_sighting(camera, board, pose);
    if (!truth) continue;
    const ImageBuffer picture = photographer.take(board, pose, 2.0, 1);
    Sighting found;
    ASSERT_TRUE(find_board(picture.pixels(), board, found)) << quarter;
    double squares = 0.0;
    Vec2 mean{0.0};
    for (std::size_t i = 0; i < found.corners.size(); ++i) {
      const Vec2 off = found.corners[i] - truth->corners[i];
      squares += glm::dot(off, off);
      mean += off;
    }
    const double count = static_cast<double>(found.corners.size());
    EXPECT_LT(std::sqrt(squares / count), 0.2) << quarter;
    EXPECT_LT(glm::length(mean / count), 0.03) << quarter;
    // A mean over a texel crosses from a tenth to nine tenths in 0.8 texels, seen through bilinear samples
    // and aslant in up to three times that.
    EXPECT_GT(found.edge_texels, 0.7) << quarter;
    EXPECT_LT(found.edge_texels, 2.5) << quarter;
  }
}

}  // namespace
}  // namespace cupola
