// The reference against the formulas written out once more, over every texel of every view.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/ewa_exact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/warp/faces.h"

namespace cupola {
namespace {

using test::Faces;

// Directions and positions on 90 degree cube faces from CONVENTIONS alone; no optics code.
struct Cube {
  Vec3 forward, right, up;
};
const Cube kCubes[] = {{{0, 0, -1}, {1, 0, 0}, {0, 1, 0}},  {{-1, 0, 0}, {0, 0, -1}, {0, 1, 0}},
                       {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},   {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},
                       {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}}, {{0, 0, 1}, {-1, 0, 0}, {0, 1, 0}}};
const std::vector<std::string> kAllNames = {"front", "left", "right", "top", "bottom", "back"};

Vec2 position(const Cube& cube, Size size, const Vec3& d) {
  const double z = glm::dot(d, cube.forward);
  return {(glm::dot(d, cube.right) / z + 1) * size.width / 2,
          (1 - glm::dot(d, cube.up) / z) * size.height / 2};
}

Vec3 omnimax_ray(const Rig& rig, double px, double py) {
  const double x = (px - rig.frame.center.x) / rig.frame.radius;
  const double y = (rig.frame.center.y - py) / rig.frame.radius;
  const double r = std::hypot(x, y);
  const double phi = 1.411269 * r - 0.094389 * std::pow(r, 3) + 0.25674 * std::pow(r, 5);
  const double theta = std::atan2(y, x);
  return {std::sin(phi) * std::cos(theta), std::sin(phi) * std::sin(theta), -std::cos(phi)};
}

int nearest_axis(const Vec3& d) {
  int best = 0;
  for (int i = 1; i < 6; ++i) {
    if (glm::dot(d, kCubes[i].forward) > glm::dot(d, kCubes[best].forward)) best = i;
  }
  return best;
}

// Area of a texel on the unit sphere falls with cos^3 of its angle: the density of texels grows by its
// inverse.
double cube_density(const Cube& cube, const Vec3& d) {
  return 1.0 / std::pow(glm::dot(d, cube.forward), 3);
}

// The filter by its definition: Jacobian by differences, every texel of every face asked.
std::array<double, 3> by_definition(const Rig& rig, const Faces& faces, int px, int py) {
  const Size size = rig.views[0].size;
  const Vec3 d = omnimax_ray(rig, px + 0.5, py + 0.5);
  const int home = nearest_axis(d);
  const Vec2 centre = position(kCubes[home], size, d);
  constexpr double kStep = 1e-4;
  const auto at = [&](double x, double y) { return position(kCubes[home], size, omnimax_ray(rig, x, y)); };
  const Vec2 by_x = (at(px + 0.5 + kStep, py + 0.5) - at(px + 0.5 - kStep, py + 0.5)) / (2 * kStep);
  const Vec2 by_y = (at(px + 0.5, py + 0.5 + kStep) - at(px + 0.5, py + 0.5 - kStep)) / (2 * kStep);
  const double a = by_x.y * by_x.y + by_y.y * by_y.y + rig.filter.rec;
  const double b = -2 * (by_x.x * by_x.y + by_y.x * by_y.y);
  const double c = by_x.x * by_x.x + by_y.x * by_y.x + rig.filter.rec;
  const double f = a * c - b * b / 4;
  std::array<double, 3> num{};
  double den = 0;
  for (int face = 0; face < 6; ++face) {
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const double s = (x + 0.5) * 2 / size.width - 1;
        const double t = 1 - (y + 0.5) * 2 / size.height;
        const Vec3 texel =
            glm::normalize(kCubes[face].forward + s * kCubes[face].right + t * kCubes[face].up);
        if (glm::dot(texel, kCubes[home].forward) <= 0 || glm::dot(texel, d) <= 0) continue;
        const Vec2 offset = position(kCubes[home], size, texel) - centre;
        const double q = (a * offset.x * offset.x + b * offset.x * offset.y + c * offset.y * offset.y) / f;
        if (q >= rig.filter.radius * rig.filter.radius) continue;
        const double weight = std::exp(-rig.filter.alpha * q) * cube_density(kCubes[home], texel) /
                              cube_density(kCubes[face], texel);
        for (int channel = 0; channel < 3; ++channel) {
          num[channel] += weight * faces.images[face].samples<std::uint8_t>(channel, y)[x];
        }
        den += weight;
      }
    }
  }
  return {num[0] / den, num[1] / den, num[2] / den};
}

class EwaExactFilter : public testing::TestWithParam<FilterSettings> {};

TEST_P(EwaExactFilter, IsTheDefinitionOverAllTexelsOfAllFaces) {
  Rig rig = test::omnimax_rig({96, 96}, 96, {68, 60}, kAllNames);
  rig.filter = GetParam();
  const Faces faces = test::make_faces(rig, test::noise(1));
  int compared = 0;
  for (int y = 0; y < 96; y += 1) {
    for (int x = y % 3; x < 96; x += 3) {
      if (std::hypot(x + 0.5 - 48, y + 0.5 - 48) > 47.9) continue;
      if (std::abs(std::abs(x + 0.5 - 48) - std::abs(y + 0.5 - 48)) < 0.1) continue;  // a tie of two faces
      const auto exact = ewa_exact(rig, faces.images, x, y);
      const auto definition = by_definition(rig, faces, x, y);
      for (int channel = 0; channel < 3; ++channel)
        ASSERT_NEAR(exact[channel], definition[channel], 1e-3) << x << ' ' << y;
      ++compared;
    }
  }
  EXPECT_GT(compared, 2000);
}

// smallest_axis = 0.75 / radius stays below this geometry's least axis of 0.7 texels for radii above 1.1.
INSTANTIATE_TEST_SUITE_P(Settings, EwaExactFilter,
                         testing::Values(FilterSettings{Kernel::kGaussian, 2.0, 2.0, 0.0, {}},
                                         FilterSettings{Kernel::kGaussian, 3.0, 1.25, 0.0, {}},
                                         FilterSettings{Kernel::kGaussian, 2.0, 1.5, 1.0, {}}));

// The pseudocode of 1986, page 25, as printed but for one channel read from a face.
double paper_ewa(const Image& texture, double u0, double v0, double a, double b, double c, double f,
                 double alpha, double radius) {
  const double limit = radius * radius;
  const double scale = limit / f;  // so that Q = F is the cutoff
  a *= scale;
  b *= scale;
  c *= scale;
  double num = 0;
  double den = 0;
  const double ddq = 2 * a;
  const int u1 = 0;
  const double u_start = u1 + 0.5 - u0;
  for (int v = 0; v < texture.size.height; ++v) {
    const double big_v = v + 0.5 - v0;
    double dq = a * (2 * u_start + 1) + b * big_v;
    double q = (c * big_v + b * u_start) * big_v + a * u_start * u_start;
    for (int u = u1; u < texture.size.width; ++u) {
      if (q < limit * limit) {
        const double weight = std::exp(-alpha * q / limit);
        num += weight * texture.samples<std::uint8_t>(0, v)[u];
        den += weight;
      }
      q += dq;
      dq += ddq;
    }
  }
  return num / den;
}

TEST(EwaExact, IsThePseudocodeOf1986InTheMiddleOfAFace) {
  Rig rig = test::omnimax_rig({60, 60}, 60, {40, 40}, kAllNames);
  rig.filter = paper_preset();
  const Faces faces = test::make_faces(rig, test::noise(2));
  for (int y = 25; y < 35; ++y) {
    for (int x = 25; x < 35; ++x) {
      DirectionAndSlope looking;
      ViewSample at;
      ASSERT_TRUE(ray(rig.frame, {x + 0.5, y + 0.5}, looking) &&
                  project(rig.views[0], looking.direction, at));
      const double ux = glm::dot(at.du, looking.d_da);
      const double vx = glm::dot(at.dv, looking.d_da);
      const double uy = glm::dot(at.du, looking.d_db);
      const double vy = glm::dot(at.dv, looking.d_db);
      const double f = (ux * vy - uy * vx) * (ux * vy - uy * vx);
      const double printed = paper_ewa(faces.images[0], at.uv.x, at.uv.y, vx * vx + vy * vy,
                                       -2 * (ux * vx + uy * vy), ux * ux + uy * uy, f, 2.0, 2.0);
      ASSERT_NEAR(ewa_exact(rig, faces.images, x, y)[0], printed, 1e-8);
    }
  }
}

TEST(EwaExact, EvenColourStaysEvenThroughSeamsAndCorners) {
  const Rig rig = test::omnimax_rig({64, 64}, 64, {32, 32}, kAllNames);
  const Faces faces =
      test::make_faces(rig, [](int, int channel, int, int) { return channel == 0 ? 255U : 77U; });
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const auto rgb = ewa_exact(rig, faces.images, x, y);
      DirectionAndSlope looking;
      const bool inside = ray(rig.frame, {x + 0.5, y + 0.5}, looking);
      EXPECT_NEAR(rgb[0], inside ? 255.0 : 0.0, 1e-10);
      EXPECT_NEAR(rgb[2], inside ? 77.0 : 0.0, 1e-10);
    }
  }
}

TEST(EwaExact, NoFootprintIsEmptyUnderStrongMagnification) {
  // 16 texels to 400 pixels: the pixel's own ellipse is a 20th of a texel.
  Rig rig = test::omnimax_rig({400, 400}, 400, {16, 16}, kAllNames);
  for (const double radius : {1.0, 2.0, 0.5}) {
    rig.filter.radius = radius;
    const Faces faces = test::make_faces(rig, [](int, int, int, int) { return 200U; });
    for (int y = 3; y < 400; y += 7) {
      for (int x = 3; x < 400; x += 7) {
        if (std::hypot(x + 0.5 - 200, y + 0.5 - 200) > 200) continue;
        ASSERT_NEAR(ewa_exact(rig, faces.images, x, y)[1], 200.0, 1e-9) << x << ' ' << y << ' ' << radius;
      }
    }
  }
}

TEST(EwaExact, UncoveredAndOutsidePixelsAreZero) {
  const Rig rig = test::omnimax_rig({64, 64}, 64, {32, 32}, {"front", "top"});
  const Faces faces = test::make_faces(rig, [](int, int, int, int) { return 255U; });
  EXPECT_EQ(ewa_exact(rig, faces.images, 0, 0)[0], 0.0);
  EXPECT_EQ(ewa_exact(rig, faces.images, 2, 32)[0], 0.0) << "the left face is missing";
  EXPECT_NEAR(ewa_exact(rig, faces.images, 32, 32)[0], 255.0, 1e-10);
}

}  // namespace
}  // namespace cupola
