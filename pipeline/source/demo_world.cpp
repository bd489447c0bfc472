// The demo: dusk over a tiled plain, measured out in degrees, with turning stars and passing balls.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>

#include "pipeline/portable/portable_math.h"
#include "pipeline/source/graticule.h"
#include "pipeline/source/noise.h"
#include "pipeline/source/worlds.h"

namespace cupola {
namespace {

using portable::kPi;
using portable::radians;

Vec3 towards(double azimuth_deg, double elevation_deg) {
  return upright_label("", azimuth_deg, elevation_deg, 0.0).centre;
}

// Rodrigues' rotation about a unit axis.
Vec3 turned(const Vec3& d, const Vec3& axis, double angle) {
  const double cosine = std::cos(angle);
  return d * cosine + glm::cross(axis, d) * std::sin(angle) + axis * (glm::dot(axis, d) * (1.0 - cosine));
}

struct Star {
  Vec3 place;    // at time 0
  Vec3 colour;   // at its peak, high in the sky
  double reach;  // radians
};

struct Ball {
  Vec3 pole;  // of the circle it runs along
  double off_pole_deg;
  double period_s;
  double start;  // turns
  double radius_deg;
  Vec3 colour;
};

const std::array<Ball, 5> kBalls = {{
    {towards(10.0, 78.0), 76.0, 36.0, 0.03, 3.3, {0.93, 0.30, 0.22}},
    {towards(90.0, 4.0), 84.0, 30.0, 0.30, 2.6, {0.98, 0.76, 0.25}},
    {towards(-60.0, 35.0), 64.0, 44.0, 0.55, 2.9, {0.25, 0.66, 0.88}},
    {towards(0.0, 40.0), 27.0, 20.0, 0.70, 1.9, {0.55, 0.85, 0.45}},
    {towards(180.0, 60.0), 68.0, 52.0, 0.15, 2.3, {0.80, 0.45, 0.85}},
}};

// A ridge line's elevation in radians: peaks from folded sines.
double ridge(double azimuth, double base_deg, double height_deg, double phase) {
  double height = 0.0, weight = 1.0, sum = 0.0;
  for (const double waves : {3.0, 7.0, 16.0, 37.0, 83.0}) {
    height += weight * (1.0 - std::abs(std::sin(0.5 * waves * azimuth + phase * waves)));
    sum += weight;
    weight *= 0.52;
  }
  // The half waves of odd numbers fold to whole periods around the horizon.
  return radians(base_deg + height_deg * height / sum);
}

class DemoWorld final : public World {
 public:
  DemoWorld() {
    std::vector<Label> labels = graticule_labels(2.4);
    lettering_ = Lettering(labels);
    Dice dice(1986);
    constexpr int kStars = 420;
    while (stars_.size() < kStars) {
      const Vec3 p{dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), dice.between(-1.0, 1.0)};
      const double square = glm::dot(p, p);
      if (square > 1.0 || square < 0.01) continue;
      const double magnitude = std::pow(dice.roll(), 3.0);  // few bright ones
      const double warmth = dice.roll();
      const Vec3 tint = glm::mix(Vec3{0.72, 0.84, 1.0}, Vec3{1.0, 0.86, 0.68}, warmth);
      stars_.push_back({p / std::sqrt(square), tint * glm::mix(0.42, 1.0, magnitude),
                        radians(glm::mix(0.19, 0.36, magnitude))});
    }
  }

  Anchor anchor() const override { return Anchor::kHorizon; }

  Vec3 backdrop(const Vec3& d) const override {
    const Horizontal at = horizontal(d);
    const double level = std::sqrt(std::max(1e-12, d.x * d.x + d.z * d.z));
    const double sunward = 0.5 + 0.5 * (d.x * kSun.x + d.z * kSun.z) / (level * kSunLevel);  // 0 to 1
    Vec3 colour = d.y > 0.0 ? sky(d, at, sunward) : ground(d, sunward);

    const GraticuleLines lines = graticule(d, at);
    colour = glm::mix(colour, Vec3{0.62, 0.80, 0.95}, 0.22 * lines.minor);
    colour = glm::mix(colour, Vec3{0.72, 0.88, 1.0}, 0.45 * lines.major);
    colour = glm::mix(colour, Vec3{1.0, 0.80, 0.45}, 0.75 * lines.first);

    colour = plate(d, colour);
    const double away = lettering_.distance(d);
    if (away < Lettering::kMargin) {
      const double shade = glm::smoothstep(Lettering::kMargin, 0.0, away);
      colour = glm::mix(colour, Vec3{0.03, 0.04, 0.09}, 0.55 * shade);
      colour = glm::mix(colour, Vec3{1.0, 0.96, 0.86}, 0.97 * line_coverage(away, 0.0));
    }
    return colour;
  }

  int sprites() const override { return static_cast<int>(stars_.size() + kBalls.size()); }

  Sprite sprite(int index, double seconds) const override {
    const auto number = static_cast<std::size_t>(index);
    if (number < stars_.size()) return star(stars_[number], seconds);
    const Ball& ball = kBalls[number - stars_.size()];
    const Vec3 side = glm::normalize(glm::cross(ball.pole, Vec3{0.31, 0.17, 0.94}));
    const double off = radians(ball.off_pole_deg);
    const Vec3 start = ball.pole * std::cos(off) + side * std::sin(off);
    const double turns = seconds / ball.period_s;
    const double angle = 2.0 * kPi * (turns - std::floor(turns) + ball.start);
    const double radius = radians(ball.radius_deg);
    const Vec3 place = turned(start, ball.pole, angle);
    return {{place, radius + kBallSoft},    0.965 * radius,        kBall, ball.colour,
            glm::normalize(kLight - place), 1.0 / std::sin(radius)};
  }

  Ink ink(const Sprite& sprite, const Vec3& d) const override {
    return sprite.kind == kBall ? ball_ink(sprite, d) : star_ink(sprite, d);
  }

 private:
  enum Kind { kStar, kBall };
  static constexpr double kBallSoft = radians(0.045);  // half its edge: a texel of a 1024 face in all
  static inline const Vec3 kLight{-0.45, 0.72, 0.53};
  static inline const Vec3 kSun = towards(-38.0, 2.0);
  static inline const double kSunLevel = std::sqrt(kSun.x * kSun.x + kSun.z * kSun.z);
  static inline const Vec3 kPole = towards(0.0, 48.0);
  static inline const Vec3 kPlate = towards(42.0, 34.0);

  static Vec3 haze(double sunward) {
    const double warm = sunward * sunward * sunward;
    return glm::mix(Vec3{0.30, 0.29, 0.47}, Vec3{0.98, 0.62, 0.36}, warm);
  }

  static Vec3 sky(const Vec3& d, const Horizontal& at, double sunward) {
    const Vec3 zenith{0.035, 0.05, 0.14};
    const Vec3 middle = glm::mix(Vec3{0.10, 0.13, 0.32}, Vec3{0.36, 0.20, 0.38}, sunward * sunward);
    const double near_horizon = std::exp(-9.0 * d.y);
    Vec3 colour = glm::mix(glm::mix(zenith, middle, std::exp(-2.6 * d.y)), haze(sunward), near_horizon);
    const double glow = std::exp(9.0 * (glm::dot(d, kSun) - 1.0));
    colour = glm::mix(colour, Vec3{1.0, 0.80, 0.52}, 0.55 * glow * near_horizon);
    if (at.elevation < radians(8.0)) {
      const double far = ridge(at.azimuth, 1.6, 5.4, 0.37);
      colour = glm::mix(colour, glm::mix(haze(sunward), Vec3{0.20, 0.15, 0.31}, 0.72),
                        line_coverage(at.elevation - far, 0.0));
      const double near = ridge(at.azimuth, 0.4, 4.0, 1.71);
      colour = glm::mix(colour, glm::mix(haze(sunward), Vec3{0.085, 0.075, 0.16}, 0.90),
                        line_coverage(at.elevation - near, 0.0));
    }
    return colour;
  }

  // A checkered plain an eye's height below, box-filtered over each texel's footprint: even grey far away.
  static Vec3 ground(const Vec3& d, double sunward) {
    constexpr double kTexel = 0.0017;  // radians, of a 1024 face
    constexpr double kTile = 0.9;      // eye heights
    const double down = std::max(-d.y, 1e-6);
    const Vec2 p = Vec2{d.x, d.z} / (down * kTile);
    const double across = kTexel / (down * kTile);  // footprint, tiles
    const double along = across / down;
    const double level_square = std::max(1e-12, d.x * d.x + d.z * d.z);
    const Vec2 share{d.x * d.x / level_square, d.z * d.z / level_square};
    const auto filtered = [](double x, double width) {
      const auto ramp = [](double y) { return std::abs(0.5 * y - std::floor(0.5 * y) - 0.5); };
      return 2.0 * (ramp(x - 0.5 * width) - ramp(x + 0.5 * width)) / width;
    };
    const Vec2 width{std::sqrt(share.x * along * along + share.y * across * across),
                     std::sqrt(share.y * along * along + share.x * across * across)};
    const double dark = 0.5 - 0.5 * filtered(p.x + 0.5, width.x) * filtered(p.y + 0.5, width.y);
    Vec3 colour = glm::mix(Vec3{0.27, 0.31, 0.42}, Vec3{0.085, 0.10, 0.18}, dark);
    const double warm = sunward * sunward * sunward;
    colour += Vec3{0.22, 0.10, 0.02} * (warm * (1.0 - down));
    return glm::mix(colour, haze(sunward) * 0.75, std::exp(-14.0 * down));
  }

  // A zone plate hung in the sky: rings down to five texels of a 1024 face.
  static Vec3 plate(const Vec3& d, const Vec3& behind) {
    constexpr double kRadius = radians(9.0);
    const double cosine = glm::dot(d, kPlate);
    if (cosine < 0.985) return behind;
    const double angle = std::acos(std::min(1.0, cosine));
    if (angle > kRadius + radians(1.0)) return behind;
    const double rings = 0.5 + 0.48 * std::cos(2300.0 * angle * angle);
    const Vec3 ink = glm::mix(Vec3{0.06, 0.07, 0.13}, Vec3{0.96, 0.95, 0.90}, rings);
    const Vec3 framed = glm::mix(behind, ink, line_coverage(angle, kRadius));
    return glm::mix(framed, Vec3{1.0, 0.80, 0.45}, line_coverage(std::abs(angle - kRadius), radians(0.16)));
  }

  static Sprite star(const Star& star, double seconds) {
    constexpr double kTurn = 900.0;  // seconds
    const double turns = seconds / kTurn;
    const Vec3 place = turned(star.place, kPole, 2.0 * kPi * (turns - std::floor(turns)));
    const double clear = glm::smoothstep(0.10, 0.36, place.y);  // the dusk swallows the low ones
    return {{place, clear > 0.0 ? star.reach : 0.0}, 0.0, kStar, star.colour * clear, Vec3{0.0},
            1.0 / (star.reach * star.reach)};
  }

  static Ink star_ink(const Sprite& sprite, const Vec3& d) {
    const Vec3 away = d - sprite.cone.axis;
    const double share = 1.0 - glm::dot(away, away) * sprite.scale;
    return {sprite.colour * (share > 0.0 ? share * share : 0.0), 0.0};
  }

  // A sphere lit from above and behind the spectator, with the dusk along its far edge.
  static Ink ball_ink(const Sprite& sprite, const Vec3& d) {
    const Vec3& axis = sprite.cone.axis;
    const double depth = glm::dot(d, axis);
    const Vec3 across = (d - depth * axis) * sprite.scale;
    const double square = glm::dot(across, across);
    double opacity = 1.0;
    if (square > 0.81) {
      const double to_edge = 0.5 + (1.0 - std::sqrt(square)) / (2.0 * kBallSoft * sprite.scale);
      if (to_edge <= 0.0 || depth < 0.0) return {Vec3{0.0}, 0.0};
      const double inside = std::min(to_edge, 1.0);
      opacity = inside * inside * (3.0 - 2.0 * inside);
    }
    const Vec3 normal = across - std::sqrt(std::max(0.0, 1.0 - square)) * axis;
    const double facing = 0.5 + 0.5 * glm::dot(normal, kLight);
    const double diffuse = 0.22 + 0.85 * facing * facing;
    const double mirror = std::max(0.0, glm::dot(normal, sprite.mirror));
    const double m4 = mirror * mirror * mirror * mirror, m16 = m4 * m4 * m4 * m4;
    const double highlight = 0.85 * m16 * m16 * m16;
    const double edge = square * square * square;
    const Vec3 colour = sprite.colour * diffuse + Vec3{0.30, 0.20, 0.22} * (0.6 * edge) + Vec3{highlight};
    return {glm::min(colour, Vec3{1.0}) * opacity, opacity};
  }

  std::vector<Star> stars_;
  Lettering lettering_;
};

}  // namespace

std::unique_ptr<const World> make_demo_world() {
  return std::make_unique<DemoWorld>();
}

}  // namespace cupola
