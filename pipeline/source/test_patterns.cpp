// The operator's test patterns.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>

#include "pipeline/portable/portable_math.h"
#include "pipeline/source/graticule.h"
#include "pipeline/source/worlds.h"

namespace cupola {
namespace {

using portable::kPi;
using portable::radians;

constexpr double kTexel = radians(0.088);  // of a 1024 face, at its middle

class Uniform final : public StillWorld {
 public:
  explicit Uniform(double level) : colour_(level) {}
  Vec3 backdrop(const Vec3&) const override { return colour_; }

 private:
  Vec3 colour_;
};

// Where a direction meets the cube: the face of its largest component and coordinates from -1 to 1, rightward
// and downward as CONVENTIONS has them.
struct CubePoint {
  int face;  // front left right top bottom back
  Vec2 at;
};
CubePoint on_cube(const Vec3& d) {
  const Vec3 size = glm::abs(d);
  if (size.z >= size.x && size.z >= size.y) {
    return d.z < 0.0 ? CubePoint{0, Vec2{d.x, -d.y} / size.z} : CubePoint{5, Vec2{-d.x, -d.y} / size.z};
  }
  if (size.x >= size.y) {
    return d.x < 0.0 ? CubePoint{1, Vec2{-d.z, -d.y} / size.x} : CubePoint{2, Vec2{d.z, -d.y} / size.x};
  }
  return d.y > 0.0 ? CubePoint{3, Vec2{d.x, -d.z} / size.y} : CubePoint{4, Vec2{d.x, d.z} / size.y};
}

// `squares`: along a face's side.
bool dark_square(const Vec2& at, int squares = 16) {
  const Vec2 square = glm::floor((at * 0.5 + 0.5) * static_cast<double>(squares));
  return (static_cast<int>(square.x) + static_cast<int>(square.y)) % 2 != 0;
}

// The paper's figure 6: squares along the faces' texels.
class Checker final : public StillWorld {
 public:
  explicit Checker(int squares) : squares_(squares) {}
  Anchor anchor() const override { return Anchor::kAxis; }
  Vec3 backdrop(const Vec3& d) const override {
    return Vec3{dark_square(on_cube(d).at, squares_) ? 0.0 : 1.0};
  }

 private:
  int squares_;
};

// Squares of equal angle on a cube turned by odd angles: their edges run along no face's texels.
class RotatedChecker final : public StillWorld {
 public:
  Vec3 backdrop(const Vec3& d) const override {
    const Vec2 at = on_cube(kTurn * d).at;
    return Vec3{dark_square(Vec2{std::atan(at.x), std::atan(at.y)} * (4.0 / kPi)) ? 0.0 : 1.0};
  }

 private:
  static Mat3 odd_turn() {
    const Vec3 x = glm::normalize(Vec3{0.83, 0.31, -0.46});
    const Vec3 y = glm::normalize(glm::cross(Vec3{0.47, -0.29, 0.83}, x));
    return glm::transpose(Mat3{x, y, glm::cross(x, y)});
  }
  static inline const Mat3 kTurn = odd_turn();
};

// cos(k angle^2) about the axis, front and back. At 90 degrees a ring is 12.6 mrad wide: 8 texels of a 1024
// face, 5 pixels of a frame 1966 wide.
class ZonePlate final : public StillWorld {
 public:
  Anchor anchor() const override { return Anchor::kAxis; }
  Vec3 backdrop(const Vec3& d) const override {
    const double angle = std::atan2(std::sqrt(d.x * d.x + d.y * d.y), std::abs(d.z));
    return Vec3{0.5 + 0.5 * std::cos(160.0 * angle * angle)};
  }
};

// Colour bars all around, a staircase of greys below.
class Bars final : public StillWorld {
 public:
  Vec3 backdrop(const Vec3& d) const override {
    const double turns = std::atan2(d.x, -d.z) / (2.0 * kPi) + 0.25;  // 0 at the left
    const double half = 2.0 * (turns - std::floor(turns));            // the bars run twice around
    const double share = half - std::floor(half);
    if (d.y > -0.2) return kColours[std::min<std::size_t>(static_cast<std::size_t>(share * 8.0), 7)];
    return Vec3{std::min(std::floor(share * 16.0), 15.0) / 15.0};
  }

 private:
  static constexpr double kFull = 0.75;
  static inline const std::array<Vec3, 8> kColours = {{{kFull, kFull, kFull},
                                                       {kFull, kFull, 0.0},
                                                       {0.0, kFull, kFull},
                                                       {0.0, kFull, 0.0},
                                                       {kFull, 0.0, kFull},
                                                       {kFull, 0.0, 0.0},
                                                       {0.0, 0.0, kFull},
                                                       {0.0, 0.0, 0.0}}};
};

class Grid final : public StillWorld {
 public:
  Grid() {
    std::vector<Label> labels = graticule_labels(2.2);
    const std::array<std::string, 4> around = {"FRONT", "RIGHT", "BACK", "LEFT"};
    for (int quarter = 0; quarter < 4; ++quarter) {
      labels.push_back(upright_label(around[static_cast<std::size_t>(quarter)], 90.0 * quarter, -5.0, 4.0));
    }
    labels.push_back({"TOP", {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, radians(4.0), radians(0.5)});
    labels.push_back({"BOTTOM", {0.0, -1.0, 0.0}, {0.0, 0.0, -1.0}, radians(4.0), radians(0.5)});
    lettering_ = Lettering(labels);
  }
  Vec3 backdrop(const Vec3& d) const override {
    const Horizontal at = horizontal(d);
    const GraticuleLines lines = graticule(d, at);
    Vec3 colour = d.y < 0.0 ? Vec3{0.035, 0.045, 0.04} : Vec3{0.03, 0.035, 0.06};
    colour = glm::mix(colour, Vec3{0.35, 0.42, 0.48}, lines.minor);
    colour = glm::mix(colour, Vec3{0.85, 0.88, 0.92}, lines.major);
    colour = glm::mix(colour, Vec3{1.0, 0.78, 0.30}, lines.first);
    // The cube's edges, dashed every five degrees.
    const Vec2 edge = glm::abs(on_cube(d).at);
    const double to_edge = (1.0 - std::max(edge.x, edge.y)) * 0.5;  // radians, nearly
    const double run = std::atan(std::min(edge.x, edge.y)) / radians(5.0);
    const double dash = glm::smoothstep(0.18, 0.20, std::abs(run - std::nearbyint(run)));
    colour = glm::mix(colour, Vec3{0.95, 0.25, 0.55}, dash * line_coverage(to_edge, radians(0.09)));
    const double away = lettering_.distance(d);
    if (away < Lettering::kMargin) {
      colour = glm::mix(colour, Vec3{0.0}, 0.8 * glm::smoothstep(Lettering::kMargin, 0.0, away));
      colour = glm::mix(colour, Vec3{1.0}, line_coverage(away, 0.0));
    }
    return colour;
  }

 private:
  Lettering lettering_;
};

// Cross-hair, circles and diagonals about the axis of projection.
class Alignment final : public StillWorld {
 public:
  Alignment() {
    std::vector<Label> labels;
    for (int angle = 15; angle < 180; angle += 15) {
      for (const double bearing : {45.0, 135.0, 225.0, 315.0}) {
        const double off = radians(angle - 1.6), around = radians(bearing + 90.0 / angle * 3.0);
        labels.push_back(
            {std::to_string(angle),
             {std::sin(off) * std::sin(around), std::sin(off) * std::cos(around), -std::cos(off)},
             {0.0, 1.0, 0.0},
             radians(2.0),
             radians(0.26)});
      }
    }
    lettering_ = Lettering(labels);
  }
  Anchor anchor() const override { return Anchor::kAxis; }
  Vec3 backdrop(const Vec3& d) const override {
    const double angle = std::atan2(std::sqrt(d.x * d.x + d.y * d.y), -d.z);
    const auto ticks = [angle](double across, double step, double half_length) {
      const double off = std::abs(angle - step * std::nearbyint(angle / step));
      return across < half_length ? line_coverage(off, radians(0.045)) : 0.0;
    };
    const double across = std::min(std::abs(d.x), std::abs(d.y));
    double white = line_coverage(across, radians(0.07));
    white = std::max(white, ticks(across, radians(1.0), radians(0.35)));
    white = std::max(white, ticks(across, radians(5.0), radians(0.8)));
    const double step = radians(15.0);
    if (angle > radians(7.0)) {
      white = std::max(white,
                       line_coverage(std::abs(angle - step * std::nearbyint(angle / step)), radians(0.07)));
    }
    const double diagonal = std::min(std::abs(d.x - d.y), std::abs(d.x + d.y)) * std::sqrt(0.5);
    Vec3 colour{white};
    colour = glm::max(colour, Vec3{0.0, 0.55, 0.75} * line_coverage(diagonal, radians(0.06)));
    // The limb of a 180 degree field.
    colour =
        glm::mix(colour, Vec3{1.0, 0.25, 0.20}, line_coverage(std::abs(angle - 0.5 * kPi), radians(0.14)));
    colour =
        glm::mix(colour, Vec3{1.0, 0.25, 0.20}, line_coverage(std::abs(angle - radians(1.0)), radians(0.07)));
    const double away = lettering_.distance(d);
    if (away < Lettering::kMargin) {
      colour = glm::mix(colour, Vec3{0.0}, glm::smoothstep(Lettering::kMargin, 0.001, away));
      colour = glm::mix(colour, Vec3{1.0, 0.85, 0.4}, line_coverage(away, 0.0));
    }
    return colour;
  }

 private:
  Lettering lettering_;
};

// Siemens stars across the field, each with line pairs of 2, 3, 4 and 6 texels of a 1024 face beside it.
class Focus final : public StillWorld {
 public:
  Focus() {
    place({0.0, 0.0, -1.0});
    for (const auto& [angle_deg, count] : {std::pair{36.0, 6}, {72.0, 12}, {105.0, 12}, {145.0, 6}}) {
      for (int i = 0; i < count; ++i) {
        const double angle = radians(angle_deg), around = 2.0 * kPi * i / count;
        place({std::sin(angle) * std::sin(around), std::sin(angle) * std::cos(around), -std::cos(angle)});
      }
    }
    std::vector<Cone> cones;
    for (const Mat3& target : targets_) cones.push_back({target[2], radians(13.0)});
    cells_ = DirectionCells(cones, 16);
  }
  Anchor anchor() const override { return Anchor::kAxis; }
  Vec3 backdrop(const Vec3& d) const override {
    constexpr double kRadius = radians(6.0);
    for (const std::uint32_t t : cells_.near(d)) {
      const Mat3& target = targets_[t];
      const double depth = glm::dot(d, target[2]);
      if (depth < 0.9) continue;
      const Vec2 p{glm::dot(d, target[0]) / depth, glm::dot(d, target[1]) / depth};
      const double radius = std::sqrt(glm::dot(p, p));
      if (radius < kRadius) return star(p, radius);
      // Line pairs: four blocks left with upright lines, four right with level ones.
      const Vec2 off = glm::abs(p);
      if (off.x > radians(6.8) && off.x < radians(9.6) && off.y < radians(6.0)) {
        const double block = (p.y / radians(12.0) + 0.5) * 4.0;
        const auto size = static_cast<std::size_t>(std::clamp(block, 0.0, 3.0));
        if (std::abs(block - std::floor(block) - 0.5) > 0.44) return kGround;
        const double wave = kTexel * std::array<double, 4>{2.0, 3.0, 4.0, 6.0}[size];
        return Vec3{0.5 + 0.5 * std::cos(2.0 * kPi * (p.x < 0.0 ? p.x : p.y) / wave)};
      }
    }
    return kGround;
  }

 private:
  static inline const Vec3 kGround{0.12};

  void place(const Vec3& centre) {
    const Vec3 right = glm::normalize(glm::cross(centre, Vec3{0.0, 1.0, 1e-6}));
    targets_.push_back(Mat3{right, glm::cross(right, centre), centre});
  }
  // 36 spokes, grey where they get narrower than two texels.
  static Vec3 star(const Vec2& p, double radius) {
    constexpr double kSpokes = 36.0;
    const double wave = 2.0 * kPi * radius / kSpokes;
    const double contrast = glm::smoothstep(2.0 * kTexel, 3.0 * kTexel, wave);
    const double edge =
        std::clamp(std::sin(kSpokes * std::atan2(p.y, p.x)) * wave / (1.5 * kTexel), -1.0, 1.0);
    return Vec3{0.5 + 0.5 * contrast * edge};
  }

  std::vector<Mat3> targets_;  // right, up, centre
  DirectionCells cells_;
};

}  // namespace

std::unique_ptr<const World> make_grid() {
  return std::make_unique<Grid>();
}
std::unique_ptr<const World> make_checker() {
  return std::make_unique<Checker>(16);
}
std::unique_ptr<const World> make_fine_checker() {
  return std::make_unique<Checker>(128);
}
std::unique_ptr<const World> make_rotated_checker() {
  return std::make_unique<RotatedChecker>();
}
std::unique_ptr<const World> make_zone_plate() {
  return std::make_unique<ZonePlate>();
}
std::unique_ptr<const World> make_white() {
  return std::make_unique<Uniform>(1.0);
}
std::unique_ptr<const World> make_grey() {
  return std::make_unique<Uniform>(128.0 / 255.0);
}
std::unique_ptr<const World> make_bars() {
  return std::make_unique<Bars>();
}
std::unique_ptr<const World> make_focus() {
  return std::make_unique<Focus>();
}
std::unique_ptr<const World> make_alignment() {
  return std::make_unique<Alignment>();
}

}  // namespace cupola
