// Meridians and parallels with their labels: what operators measure a dome with.
// SPDX-License-Identifier: MIT
#include "pipeline/source/graticule.h"

#include <algorithm>
#include <cmath>

#include "pipeline/portable/portable_math.h"

namespace cupola {

using portable::radians;

Horizontal horizontal(const Vec3& d) {
  return {std::atan2(d.x, -d.z), std::asin(std::clamp(d.y, -1.0, 1.0))};
}

double line_coverage(double distance, double half_width) {
  constexpr double kSoft = radians(0.045);
  const double inside = std::clamp((half_width + kSoft - distance) / (2.0 * kSoft), 0.0, 1.0);
  return inside * inside * (3.0 - 2.0 * inside);
}

GraticuleLines graticule(const Vec3& d, const Horizontal& at) {
  constexpr double kThin = radians(0.055), kThick = radians(0.085);
  const double cosine = std::sqrt(std::max(0.0, 1.0 - d.y * d.y));
  const auto to_nearest = [](double angle, double step) {
    return std::abs(angle - step * std::nearbyint(angle / step));
  };
  constexpr double kTen = radians(10.0), kThirty = radians(30.0);
  GraticuleLines lines;
  lines.minor = line_coverage(to_nearest(at.elevation, kTen), kThin);
  if (std::abs(at.elevation) < radians(80.0)) {
    lines.minor = std::max(lines.minor, line_coverage(to_nearest(at.azimuth, kTen) * cosine, kThin));
  }
  // Near the zenith the azimuth turns fast: the sine is the true distance to a meridian's plane.
  const double to_major = std::asin(cosine * std::sin(to_nearest(at.azimuth, kThirty)));
  lines.major =
      std::max(line_coverage(to_nearest(at.elevation, kThirty), kThick), line_coverage(to_major, kThick));
  lines.first = std::max(line_coverage(std::abs(at.elevation), kThick),
                         d.z < 0.0 ? line_coverage(std::abs(d.x), kThick) : 0.0);
  return lines;
}

std::vector<Label> graticule_labels(double height_deg) {
  std::vector<Label> labels;
  for (int azimuth = 0; azimuth < 360; azimuth += 30) {
    const std::string text = std::to_string(azimuth) + "*";
    const double half_width = 0.5 * height_deg * 0.95 * static_cast<double>(text.size());
    labels.push_back(upright_label(text, azimuth + half_width + 0.5, 0.5 * height_deg + 0.8, height_deg));
  }
  for (int azimuth = 0; azimuth < 360; azimuth += 90) {
    for (const int elevation : {-60, -30, 30, 60}) {
      const std::string text = (elevation > 0 ? "+" : "") + std::to_string(elevation) + "*";
      const double half_width = 0.5 * height_deg * 0.95 * static_cast<double>(text.size()) + 0.5;
      labels.push_back(upright_label(text, azimuth + half_width / std::cos(radians(elevation)),
                                     elevation + 0.5 * height_deg + 0.8, height_deg));
    }
  }
  return labels;
}

}  // namespace cupola
