// Errors carried through both projections to first order.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/seam_error.h"

#include <algorithm>
#include <cmath>

#include <glm/mat2x2.hpp>

#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

constexpr int kDirections = 20'000;
constexpr double kBand = 6.0 * portable::kPi / 180.0;

using Slopes = std::array<Vec2, kCameraParameters>;

// Texels of a view by steps along two directions across `d`.
glm::dmat2 across(const View& view, const Vec3& d, const Vec3& x, const Vec3& y) {
  ViewSample sample;
  project(view, d, sample);
  return {Vec2{glm::dot(sample.du, x), glm::dot(sample.dv, x)},
          Vec2{glm::dot(sample.du, y), glm::dot(sample.dv, y)}};
}

// The sum of the variances of u and v of p - q under the covariance of their parameters.
double variance(const Slopes& p, const Slopes& q, const Adjustment::Block& pp, const Adjustment::Block& qq,
                const Adjustment::Block& pq) {
  double sum = 0.0;
  for (std::size_t i = 0; i < kCameraParameters; ++i) {
    for (std::size_t j = 0; j < kCameraParameters; ++j) {
      sum += glm::dot(p[i], p[j]) * pp[i][j] + glm::dot(q[i], q[j]) * qq[i][j] -
             2.0 * glm::dot(p[i], q[j]) * pq[i][j];
    }
  }
  return std::max(0.0, sum);
}

}  // namespace

std::vector<SeamCalibration> expected_seam_errors(
    std::span<const View> views,
    const std::function<Adjustment::Block(std::size_t a, std::size_t b)>& covariance) {
  std::vector<SeamCalibration> seams;
  for (std::size_t a = 0; a < views.size(); ++a) {
    for (std::size_t b = a + 1; b < views.size(); ++b) {
      if (views[a].size == Size{} || views[b].size == Size{}) continue;
      const Adjustment::Block of_a = covariance(a, a);
      const Adjustment::Block of_b = covariance(b, b);
      const Adjustment::Block of_both = covariance(b, a);
      double sum = 0.0;
      double worst = 0.0;
      int count = 0;
      for (int i = 0; i < kDirections; ++i) {
        // Evenly over the sphere, by the golden angle.
        const double z = 1.0 - (2.0 * i + 1.0) / kDirections;
        const double turn = 2.399963229728653 * i;
        const double r = std::sqrt(1.0 - z * z);
        const Vec3 d{r * std::cos(turn), r * std::sin(turn), z};
        const auto off_axis = [&](const View& view) {
          return std::acos(std::clamp(glm::dot(view.forward, d), -1.0, 1.0));
        };
        if (std::abs(off_axis(views[a]) - off_axis(views[b])) > kBand) continue;
        if (!covers(views[a], d) || !covers(views[b], d)) continue;
        Vec2 at;
        Slopes slopes_a{};
        Slopes slopes_b{};
        if (!camera_slopes(views[a], d, at, slopes_a) || !camera_slopes(views[b], d, at, slopes_b)) continue;
        const Vec3 x = glm::normalize(glm::cross(d, std::abs(d.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
        const Vec3 y = glm::cross(d, x);
        const glm::dmat2 b_from_a = across(views[b], d, x, y) * glm::inverse(across(views[a], d, x, y));
        for (std::size_t k = 0; k < kCameraParameters; ++k) slopes_a[k] = b_from_a * slopes_a[k];
        for (std::size_t k = 3; k < 6; ++k) slopes_a[k] = slopes_b[k] = {0.0, 0.0};  // far away
        const double square = variance(slopes_b, slopes_a, of_b, of_a, of_both);
        sum += square;
        worst = std::max(worst, square);
        ++count;
      }
      if (count == 0) continue;
      seams.push_back({static_cast<int>(a), static_cast<int>(b), std::sqrt(sum / count), std::sqrt(worst)});
    }
  }
  return seams;
}

}  // namespace cupola
