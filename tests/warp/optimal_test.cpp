// The least-squares weights: the table builder's against each pixel's own dense system, and what must hold of
// any weights.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <tuple>

#include "pipeline/warp/coverage.h"
#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/footprint.h"
#include "pipeline/warp/least_squares.h"
#include "pipeline/warp/optimal_exact.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

const std::vector<std::string> kAllNames = {"front", "left", "right", "top", "bottom", "back"};

using Place = std::tuple<int, int, int>;
std::map<Place, double> by_place(const std::vector<Tap>& taps) {
  std::map<Place, double> weights;
  for (const Tap& tap : taps) weights[{tap.view, tap.y, tap.x}] += tap.weight;
  double sum = 0.0;
  for (const auto& [place, weight] : weights) sum += weight;
  for (auto& [place, weight] : weights) weight /= sum;
  return weights;
}

// Compares every `step`-th pixel of the image, `bound` being the root of a footprint's summed squares of
// errors; returns how many.
int expect_references_weights(const Rig& rig, int step, double bound) {
  const FootprintGatherer gatherer(rig);
  std::vector<Tap> taps;
  int compared = 0;
  for (int i = 0; i < rig.frame.size.width * rig.frame.size.height; i += step) {
    const int x = i % rig.frame.size.width;
    const int y = i / rig.frame.size.width;
    if (gatherer.gather(x, y, taps) != Footprint::kCovered) continue;
    DirectionAndSlope looking;
    ViewSample at;
    ray(rig.frame, {x + 0.5, y + 0.5}, looking);
    const int home = owner(rig.views, looking.direction);
    project(rig.views[home], looking.direction, at);
    std::map<Place, double> difference = by_place(optimal_exact(rig, home, looking, at));
    double sum = 0.0;
    for (const Tap& tap : taps) {
      difference[{tap.view, tap.y, tap.x}] -= tap.weight;
      sum += tap.weight;
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
    double squares = 0.0;
    for (const auto& [place, error] : difference) squares += error * error;
    EXPECT_LT(std::sqrt(squares), bound) << x << ' ' << y;
    ++compared;
  }
  return compared;
}

Rig optimal_rig(Rig rig, double noise = 1e-3) {
  rig.filter = optimal_filter(noise);
  return rig;
}

TEST(OptimalWeights, AreTheReferencesInThePaperGeometry) {
  EXPECT_GT(expect_references_weights(optimal_rig(test::paper_rig({1024, 960})), 24407, 3.5e-3), 80);
}

TEST(OptimalWeights, AreTheReferencesForEveryNoise) {
  for (const double noise : {1e-5, 1e-4, 1e-2, 0.3}) {
    expect_references_weights(optimal_rig(test::paper_rig({1024, 1024}), noise), 120011, 3.5e-3);
  }
}

TEST(OptimalWeights, AreTheReferencesAcrossSeamsAndCorners) {
  EXPECT_GT(expect_references_weights(optimal_rig(test::omnimax_rig({40, 40}, 40, {18, 17}, kAllNames)), 11,
                                      3.5e-3),
            100);
}

TEST(OptimalWeights, AreTheReferencesUnderMagnification) {
  expect_references_weights(optimal_rig(test::omnimax_rig({200, 200}, 200, {12, 9}, kAllNames)), 397, 3.5e-3);
}

TEST(OptimalWeights, AreTheReferencesWhereTheyFadeToCoverage) {
  expect_references_weights(optimal_rig(test::omnimax_rig({24, 24}, 24, {70, 66}, kAllNames)), 31, 3.5e-3);
  expect_references_weights(optimal_rig(test::omnimax_rig({24, 24}, 24, {160, 120}, kAllNames)), 31, 3.5e-3);
}

TEST(OptimalWeights, AreTheReferencesOfTinyAndUnevenFaces) {
  for (const Size face : {Size{1, 1}, Size{3, 40}, Size{5, 4}, Size{200, 2}}) {
    expect_references_weights(optimal_rig(test::omnimax_rig({24, 24}, 24, face, kAllNames)), 37, 6e-3);
  }
}

TEST(OptimalWeights, AreTheReferencesOfOverlappingAndCalibratedViews) {
  Rig rig = optimal_rig(test::omnimax_rig({32, 32}, 32, {24, 20}, {"front", "left", "right", "top"}));
  for (View& view : rig.views) {
    view.focal = {0.42, 0.44};
    view.distortion = Distortion::kRadialTangential;
    view.coefficients = {-0.05, 0.01, 0.001, -0.001, 0.0};
    view.limit = 3.0;
  }
  rig.views[1].distortion = Distortion::kFisheye;
  rig.views[1].coefficients = {-0.01, 0.001, 0.0, 0.0};
  expect_references_weights(rig, 17, 3.5e-3);
}

// All the area there is, and the weights of a window by position.
struct Solved {
  TexelWindow window;
  std::vector<double> weights;
};
Solved solve(const LeastSquares& solver, const PixelArea& area) {
  const auto place = [](double centre, int side) {
    return static_cast<int>(std::floor(centre - 0.5)) - side / 2 + 1;
  };
  TexelWindow window{0, 0, LeastSquares::side_for(std::abs(area.ux) + std::abs(area.uy)),
                     LeastSquares::side_for(std::abs(area.vx) + std::abs(area.vy))};
  window.x = place(area.u, window.width);
  window.y = place(area.v, window.height);
  std::vector<double> weights(static_cast<std::size_t>(window.width * window.height));
  solver.weigh(area, window, weights.data());
  return {window, weights};
}

class LeastSquaresOf : public testing::Test {
 protected:
  double uniform(double low, double high) { return std::uniform_real_distribution<>(low, high)(random_); }
  // Of a pixel whose sides are up to `most` texels.
  PixelArea any_area(double most) {
    return {uniform(50, 51),      uniform(50, 51),      uniform(-most, most),
            uniform(-most, most), uniform(-most, most), uniform(-most, most)};
  }
  std::mt19937 random_{5};
  LeastSquares solver_{1e-3};
};

TEST_F(LeastSquaresOf, AnyPixelSumToOne) {
  for (int i = 0; i < 3000; ++i) {
    const Solved solved = solve(solver_, any_area(i % 3 == 0 ? 0.01 : 4.8));
    ASSERT_NEAR(std::accumulate(solved.weights.begin(), solved.weights.end(), 0.0), 1.0, 1e-11);
    for (const double weight : solved.weights) ASSERT_LT(std::abs(weight), 1.5);
  }
}

TEST_F(LeastSquaresOf, APixelThatIsATexelAreThatTexelButForTheNoise) {
  const Solved solved = solve(LeastSquares(1e-6), {50.5 - 1e-9, 50.5 + 1e-9, 1, 0, 0, 1});
  for (std::size_t i = 0; i < solved.weights.size(); ++i) {
    const bool it =
        solved.window.x + static_cast<int>(i) % 4 == 50 && solved.window.y + static_cast<int>(i) / 4 == 50;
    EXPECT_NEAR(solved.weights[i], it ? 1.0 : 0.0, 1e-3) << i;
  }
}

TEST_F(LeastSquaresOf, AMirroredPixelAreMirrored) {
  for (int i = 0; i < 500; ++i) {
    const PixelArea area = any_area(3.0);
    const PixelArea mirrored{101.0 - area.u, area.v, -area.ux, -area.uy, area.vx, area.vy};
    const PixelArea transposed{area.v, area.u, area.vx, area.vy, area.ux, area.uy};
    const Solved a = solve(solver_, area);
    const Solved b = solve(solver_, mirrored);
    const Solved c = solve(solver_, transposed);
    ASSERT_EQ(b.window.x, 101 - a.window.x - a.window.width);
    for (int y = 0; y < a.window.height; ++y) {
      for (int x = 0; x < a.window.width; ++x) {
        const double weight = a.weights[y * a.window.width + x];
        ASSERT_NEAR(b.weights[y * a.window.width + a.window.width - 1 - x], weight, 1e-9);
        ASSERT_NEAR(c.weights[x * a.window.height + y], weight, 1e-9);
      }
    }
  }
}

TEST_F(LeastSquaresOf, APixelOfOneTexelNeedFourByFourHoweverItIsTurned) {
  for (double side = 0.0; side <= 1.25; side += 0.05) {
    for (double angle = 0.0; angle < 1.6; angle += 0.1) {
      const double extent = side * (std::abs(std::cos(angle)) + std::abs(std::sin(angle)));
      EXPECT_EQ(LeastSquares::side_for(extent), 4) << side << ' ' << angle;
    }
  }
  EXPECT_EQ(LeastSquares::side_for(2.0 * std::sqrt(2.0)), 6);
  EXPECT_EQ(LeastSquares::side_for(LeastSquares::kMostExtent), 12);
}

// Mean over a parallelogram of what lies beyond a line with the unit normal n.
double beyond(const PixelArea& area, const Vec2& n, double offset) {
  constexpr int kPoints = 24;
  int count = 0;
  for (int j = 0; j < kPoints; ++j) {
    for (int i = 0; i < kPoints; ++i) {
      const double a = (i + 0.5) / kPoints - 0.5;
      const double b = (j + 0.5) / kPoints - 0.5;
      const Vec2 p{area.u + area.ux * a + area.uy * b, area.v + area.vx * a + area.vy * b};
      count += glm::dot(p, n) > offset ? 1 : 0;
    }
  }
  return static_cast<double>(count) / (kPoints * kPoints);
}

// The figures of docs/performance.md; `side`: texels a pixel.
struct AtEdges {
  double overshoot = 0.0;
  double psnr_db = 0.0;
};
AtEdges at_edges(double noise, double side) {
  const LeastSquares solver(noise);
  std::mt19937 random(1);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  AtEdges edges;
  double squares = 0.0;
  constexpr int kEdges = 1500;
  for (int i = 0; i < kEdges; ++i) {
    const double turn = uniform(0.0, 6.28);
    const double u = 50.0 + uniform(0.0, 1.0);
    const double v = 50.0 + uniform(0.0, 1.0);
    const PixelArea area{
        u, v, side * std::cos(turn), -side * std::sin(turn), side * std::sin(turn), side * std::cos(turn)};
    const Solved solved = solve(solver, area);
    const double angle = uniform(0.0, 6.28);
    const Vec2 n{std::cos(angle), std::sin(angle)};
    const double offset = glm::dot(Vec2{u, v}, n) + uniform(-2.0, 2.0) * side;
    double value = 0.0;
    for (std::size_t k = 0; k < solved.weights.size(); ++k) {
      const int column = static_cast<int>(k) % solved.window.width;
      const int row = static_cast<int>(k) / solved.window.width;
      value += solved.weights[k] *
               beyond({solved.window.x + column + 0.5, solved.window.y + row + 0.5, 1, 0, 0, 1}, n, offset);
    }
    edges.overshoot = std::max({edges.overshoot, value - 1.0, -value});
    squares += (value - beyond(area, n, offset)) * (value - beyond(area, n, offset));
  }
  edges.psnr_db = -10.0 * std::log10(squares / kEdges);
  return edges;
}

TEST(LeastSquaresAt, HardEdgesOvershootByATenthAtMostAndLessWithMoreNoise) {
  for (const double side : {1.0, 2.0}) {
    AtEdges sharper{1.0, 100.0};
    for (const double noise : {1e-4, 1e-3, 1e-2}) {
      const AtEdges edges = at_edges(noise, side);
      EXPECT_LT(edges.overshoot, side == 1.0 ? 0.105 : 0.035) << noise;
      EXPECT_LT(edges.overshoot, sharper.overshoot) << noise;
      EXPECT_GT(edges.psnr_db, side == 1.0 ? 23.5 : 36.0) << noise;
      EXPECT_LT(edges.psnr_db, sharper.psnr_db + 0.05) << noise;
      sharper = edges;
    }
  }
}

// Moving a pixel by a thousandth of a texel moves its weights little, also where the window jumps by a texel.
TEST_F(LeastSquaresOf, NeighbouringPhasesAreNeighbours) {
  for (const double side : {0.2, 0.7, 1.0, 1.2}) {
    std::map<std::pair<int, int>, double> before;
    double largest = 0.0;
    for (int step = 0; step <= 1000; ++step) {
      const Solved solved =
          solve(solver_, {50.0 + step * 1e-3, 50.3, side * 0.8, -side * 0.6, side * 0.6, side * 0.8});
      std::map<std::pair<int, int>, double> now;
      for (std::size_t i = 0; i < solved.weights.size(); ++i) {
        now[{solved.window.x + static_cast<int>(i) % 4, solved.window.y + static_cast<int>(i) / 4}] =
            solved.weights[i];
      }
      if (step > 0) {
        std::map<std::pair<int, int>, double> change = now;
        for (const auto& [place, weight] : before) change[place] -= weight;
        for (const auto& [place, weight] : change) largest = std::max(largest, std::abs(weight));
      }
      before = now;
    }
    EXPECT_LT(largest, 0.02) << side;
  }
}

TEST(CoverageOf, AnyParallelogramSumsToItsAreaAndIsNeverEmpty) {
  std::mt19937 random(3);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  for (int i = 0; i < 500; ++i) {
    const double size = std::exp(uniform(-9, 4));
    const double thin = i % 2 == 0 ? 1.0 : std::exp(uniform(-9, 0));
    const double turn = uniform(0, 6.3);
    const double lean = uniform(-0.3, 0.3);
    const PixelArea area{uniform(0, 1),         uniform(0, 1),
                         size * std::cos(turn), -size * thin * std::sin(turn) + lean * size * thin,
                         size * std::sin(turn), size * thin * std::cos(turn)};
    const Coverage coverage(area);
    double sum = 0.0;
    for (int y = static_cast<int>(-coverage.half_height()) - 2; y <= coverage.half_height() + 2; ++y) {
      for (int x = static_cast<int>(-coverage.half_width()) - 2; x <= coverage.half_width() + 2; ++x) {
        const double share = coverage(x + 0.5 - area.u, y + 0.5 - area.v);
        ASSERT_GE(share, 0.0);
        sum += share;
      }
    }
    const double exact = std::abs(area.ux * area.vy - area.uy * area.vx);
    ASSERT_GT(sum, std::max(1.0, exact) * (1 - 1e-9));
    if (thin == 1.0 && size > 4) {
      ASSERT_NEAR(sum, exact, exact * 1e-9);
    }
  }
}

TEST(OptimalWeights, EvenColourStaysEvenThroughSeamsCornersAndExtremes) {
  for (const Size face : {Size{32, 32}, Size{2, 2}, Size{1, 400}, Size{700, 700}}) {
    const Rig rig = optimal_rig(test::omnimax_rig({48, 48}, 48, face, kAllNames));
    const FootprintGatherer gatherer(rig);
    std::vector<Tap> taps;
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 48; ++x) {
        const Footprint found = gatherer.gather(x, y, taps);
        ASSERT_NE(found, Footprint::kUncovered);
        double sum = 0.0;
        for (const Tap& tap : taps) {
          ASSERT_TRUE(tap.x >= 0 && tap.y >= 0 && tap.x < face.width && tap.y < face.height);
          ASSERT_LE(std::abs(tap.weight), 2.0);
          sum += tap.weight;
        }
        ASSERT_NEAR(sum, found == Footprint::kCovered ? 1.0 : 0.0, 1e-12);
      }
    }
  }
}

}  // namespace
}  // namespace cupola
