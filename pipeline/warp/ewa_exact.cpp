// Every step of the filter written out; shares nothing with the table builder but the optics.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/ewa_exact.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/frame/srgb_curve.h"
#include "pipeline/warp/optimal_exact.h"

namespace cupola {
namespace {

struct Jacobian {
  double ux, uy, vx, vy;  // texels a pixel
  double determinant;     // by itself: the four lose it where the axes differ by 10^7
};

// J = R(a) diag(s1, s2) R(b): both singular values are raised to `least`.
Jacobian raise_singular_values(const Jacobian& j, double least) {
  const double e = (j.ux + j.vy) / 2;
  const double f = (j.ux - j.vy) / 2;
  const double g = (j.vx + j.uy) / 2;
  const double h = (j.vx - j.uy) / 2;
  const double q = std::hypot(e, h);
  const double r = std::hypot(f, g);
  double s1 = q + r;
  double s2 = q - r;  // its sign is that of the determinant
  if (std::abs(s2) >= least) return j;
  const double a1 = std::atan2(g, f);
  const double a2 = std::atan2(h, e);
  const double a = (a2 + a1) / 2;
  const double b = (a2 - a1) / 2;
  s1 = std::max(s1, least);
  s2 = std::copysign(std::max(std::abs(s2), least), s2);
  return {std::cos(a) * s1 * std::cos(b) - std::sin(a) * s2 * std::sin(b),
          -std::cos(a) * s1 * std::sin(b) - std::sin(a) * s2 * std::cos(b),
          std::sin(a) * s1 * std::cos(b) + std::cos(a) * s2 * std::sin(b),
          -std::sin(a) * s1 * std::sin(b) + std::cos(a) * s2 * std::cos(b), s1 * s2};
}

struct Ellipse {
  double u0, v0;
  double a, b, c, f;

  double q(double u, double v) const {
    const double du = u - u0;
    const double dv = v - v0;
    return (a * du * du + b * du * dv + c * dv * dv) / f;
  }
};

// Between samples as they are encoded and what is summed; both in the face's units.
class SampleLight {
 public:
  SampleLight(const SampleSettings& samples, const Image& face)
      : linear_(samples.linear_light), most_(sample_bytes(face.format) == 2 ? 65535.0 : 255.0) {}

  double texel(const Image& face, int channel, int x, int y) const {
    const double value = face.format == PixelFormat::kRgbPlanar16 ? face.samples<std::uint16_t>(channel, y)[x]
                                                                  : face.samples<std::uint8_t>(channel, y)[x];
    return linear_ ? most_ * light_of_srgb(value / most_) : value;
  }
  std::array<double, 3> encoded(std::array<double, 3> rgb) const {
    if (linear_) {
      for (double& value : rgb) value = most_ * srgb_of_light(value / most_);
    }
    return rgb;
  }

 private:
  bool linear_;
  double most_;
};

struct WeightedSum {
  const SampleLight& light;
  std::array<double, 3> num{};
  double den = 0.0;

  void add(double weight, const Image& face, int x, int y) {
    for (int channel = 0; channel < 3; ++channel) num[channel] += weight * light.texel(face, channel, x, y);
    den += weight;
  }
  std::array<double, 3> mean() const { return light.encoded({num[0] / den, num[1] / den, num[2] / den}); }
};

// Texels of positive and of negative weight apart: see kLeastSignedShare.
struct SignedSum {
  explicit SignedSum(const SampleLight& light) : positive{light}, negative{light} {}

  WeightedSum positive;
  WeightedSum negative;

  void add(double weight, const Image& face, int x, int y) {
    (weight > 0.0 ? positive : negative).add(weight, face, x, y);
  }
  std::array<double, 3> mean() const {
    if (!(positive.den > 0.0)) return {};
    WeightedSum all = positive;
    all.den += negative.den;
    for (int channel = 0; channel < 3; ++channel) all.num[channel] += negative.num[channel];
    return all.den < kLeastSignedShare * (positive.den - negative.den) ? positive.mean() : all.mean();
  }
};

std::array<double, 3> weighted(const Rig& rig, const std::vector<Tap>& taps, std::span<const Image> faces) {
  const SampleLight light(rig.samples, faces.front());
  WeightedSum sum{light};
  for (const Tap& tap : taps) sum.add(tap.weight, faces[tap.view], tap.x, tap.y);
  return sum.den > 0.0 ? sum.mean() : std::array<double, 3>{};
}

double jinc(double s) {
  const double x = std::numbers::pi * s;
  return x < 1e-6 ? 1.0 : 2.0 * std::cyl_bessel_j(1.0, x) / x;
}

double kernel(const FilterSettings& filter, double q) {
  const double s = std::sqrt(q);
  switch (filter.kernel) {
    case Kernel::kRobidoux: {
      constexpr double kB = 0.37821575509399867;
      constexpr double kC = 0.31089212245300067;
      if (s >= 2.0) return 0.0;
      if (s < 1.0) {
        return 1.0 - kB / 3 - (3 - 2 * kB - kC) * s * s + (2 - 1.5 * kB - kC) * s * s * s;
      }
      const double t = 2.0 - s;  // the outer piece about its end
      return (kB / 6 + kC) * t * t * t - kC * t * t;
    }
    case Kernel::kJinc:
      return jinc(s) * jinc(s * 1.2196698912665045 / filter.radius);
    default:
      return std::exp(-filter.alpha * q);
  }
}

// An angle around `d` within which all of the box of half sides (wide, high) about the ellipse's centre lies.
double angle_around(const View& home, const Vec3& d, const ViewSample& at, double wide, double high) {
  if (home.distortion != Distortion::kNone) {
    // Texels a radian, in the direction where they are fewest; doubled, since the model bends.
    const double uu = glm::dot(at.du, at.du);
    const double vv = glm::dot(at.dv, at.dv);
    const double uv = glm::dot(at.du, at.dv);
    const double fewest = std::sqrt(std::max(1e-12, (uu + vv) / 2 - std::hypot((uu - vv) / 2, uv)));
    return std::min(2.0 * std::hypot(wide, high) / fewest, kFarthest);
  }
  double least = 1.0;
  for (const double u : {at.uv.x - wide, at.uv.x + wide}) {
    for (const double v : {at.uv.y - high, at.uv.y + high}) {
      least = std::min(least, glm::dot(d, direction_at(home, {u, v})));
    }
  }
  // Past that the corners do not speak for the box: the eye is in the cone's cap.
  if (least <= glm::length(home.shift)) return kFarthest;
  return std::min(std::acos(std::clamp(least, -1.0, 1.0)) + 1e-9, kFarthest);
}

// The shares of optics/seam.h once more.
std::vector<double> shares_at(const Rig& rig, const Vec3& d) {
  const double width = rig.seams.feather_deg * std::numbers::pi / 180.0;
  const auto smooth = [](double t) { return t <= 0.0 ? 0.0 : t >= 1.0 ? 1.0 : t * t * (3.0 - 2.0 * t); };
  std::vector<double> shares(rig.views.size());
  std::vector<double> angles(rig.views.size(), std::numbers::pi);
  for (std::size_t v = 0; v < rig.views.size(); ++v) {
    if (covers(rig.views[v], d))
      angles[v] = std::acos(std::clamp(glm::dot(d, rig.views[v].forward), -1.0, 1.0));
  }
  const double best = *std::min_element(angles.begin(), angles.end());
  for (std::size_t v = 0; v < rig.views.size(); ++v) {
    const View& view = rig.views[v];
    ViewSample at;
    if (!covers(view, d) || !project(view, d, at)) continue;
    const double u = std::min(at.uv.x, view.size.width - at.uv.x);
    const double w = std::min(at.uv.y, view.size.height - at.uv.y);
    const double inside = std::max(0.0, std::min(u, w)) / std::sqrt(density(at, d));
    shares[v] = smooth(1.0 - (angles[v] - best) / width) * smooth(2.0 * inside / width);
  }
  return shares;
}

std::array<double, 3> of_home(const Rig& rig, std::span<const Image> faces, const DirectionAndSlope& looking);

// Mixed as light where samples are filtered as light.
std::array<double, 3> mixed(const Rig& rig, std::span<const Image> faces, const DirectionAndSlope& looking,
                            const std::vector<double>& shares) {
  const double most = sample_bytes(faces.front().format) == 2 ? 65535.0 : 255.0;
  const bool linear = rig.samples.linear_light;
  std::array<double, 3> total{};
  double all = 0.0;
  for (std::size_t v = 0; v < shares.size(); ++v) {
    if (shares[v] == 0.0) continue;
    Rig alone = rig;
    alone.views = {rig.views[v]};
    const std::array<double, 3> rgb = of_home(alone, faces.subspan(v, 1), looking);
    for (std::size_t i = 0; i < 3; ++i)
      total[i] += shares[v] * (linear ? most * light_of_srgb(rgb[i] / most) : rgb[i]);
    all += shares[v];
  }
  for (double& value : total) value = linear ? most * srgb_of_light(value / all / most) : value / all;
  return total;
}

std::array<double, 3> of_home(const Rig& rig, std::span<const Image> faces,
                              const DirectionAndSlope& looking) {
  const int home = owner(rig.views, looking.direction);
  if (home < 0) return {};
  const View& view = rig.views[static_cast<std::size_t>(home)];
  ViewSample at;
  if (!project(view, looking.direction, at)) return {};

  const FilterSettings& filter = rig.filter;
  if (filter.kernel == Kernel::kOptimal) {
    return weighted(rig, optimal_exact(rig, home, looking, at), faces);
  }
  Jacobian j{glm::dot(at.du, looking.d_da), glm::dot(at.du, looking.d_db), glm::dot(at.dv, looking.d_da),
             glm::dot(at.dv, looking.d_db), 0.0};
  j.determinant = j.ux * j.vy - j.uy * j.vx;
  j = raise_singular_values(j, smallest_axis(filter));
  Ellipse ellipse{at.uv.x,
                  at.uv.y,
                  j.vx * j.vx + j.vy * j.vy + filter.rec,
                  -2.0 * (j.ux * j.vx + j.uy * j.vy),
                  j.ux * j.ux + j.uy * j.uy + filter.rec,
                  0.0};
  // A C - B^2 / 4, multiplied out.
  ellipse.f = j.determinant * j.determinant + filter.rec * (ellipse.a + ellipse.c - filter.rec);
  const double limit = filter.radius * filter.radius;
  const double wide = filter.radius * std::sqrt(ellipse.c);
  const double high = filter.radius * std::sqrt(ellipse.a);

  const SampleLight light(rig.samples, faces.front());
  SignedSum sum(light);
  const int x0 = static_cast<int>(std::max(0.0, std::floor(at.uv.x - wide - 0.5)));
  const int x1 = static_cast<int>(std::min(view.size.width - 1.0, std::ceil(at.uv.x + wide - 0.5)));
  const int y0 = static_cast<int>(std::max(0.0, std::floor(at.uv.y - high - 0.5)));
  const int y1 = static_cast<int>(std::min(view.size.height - 1.0, std::ceil(at.uv.y + high - 0.5)));
  for (int v = y0; v <= y1; ++v) {
    for (int u = x0; u <= x1; ++u) {
      const double q = ellipse.q(u + 0.5, v + 0.5);
      if (q >= limit) continue;
      const Vec3 d = direction_at(view, {u + 0.5, v + 0.5});
      if (glm::dot(d, looking.direction) <= kFarthestCosine || owner(rig.views, d) != home) continue;
      sum.add(kernel(filter, q), faces[home], u, v);
    }
  }

  const double angle = angle_around(view, looking.direction, at, wide, high);
  for (std::size_t other = 0; other < rig.views.size(); ++other) {
    if (static_cast<int>(other) == home) continue;
    const View& own = rig.views[other];
    const TexelBox box = texels_near(own, looking.direction, angle);
    for (int v = box.y0; v < box.y1; ++v) {
      for (int u = box.x0; u < box.x1; ++u) {
        const Vec3 d = direction_at(own, {u + 0.5, v + 0.5});
        ViewSample in_home;
        if (glm::dot(d, looking.direction) <= kFarthestCosine || !project(view, d, in_home)) continue;
        const double q = ellipse.q(in_home.uv.x, in_home.uv.y);
        if (q >= limit || owner(rig.views, d) != static_cast<int>(other)) continue;
        ViewSample in_own;
        project(own, d, in_own);
        sum.add(kernel(filter, q) * density(in_home, d) / density(in_own, d), faces[other], u, v);
      }
    }
  }
  return sum.mean();
}

}  // namespace

std::array<double, 3> ewa_exact(const Rig& rig, std::span<const Image> faces, int x, int y) {
  DirectionAndSlope looking;
  if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking)) return {};
  if (rig.seams.feather_deg > 0.0) {
    const std::vector<double> shares = shares_at(rig, looking.direction);
    if (std::count_if(shares.begin(), shares.end(), [](double share) { return share > 0.0; }) > 1)
      return mixed(rig, faces, looking, shares);
  }
  return of_home(rig, faces, looking);
}

UnroundedFilter::UnroundedFilter(const Rig& rig) : rig_(rig) {
  if (rig.filter.kernel == Kernel::kOptimal) gatherer_ = std::make_unique<FootprintGatherer>(rig);
}

std::array<double, 3> UnroundedFilter::operator()(std::span<const Image> faces, int x, int y) const {
  if (!gatherer_) return ewa_exact(rig_, faces, x, y);
  std::vector<Tap> taps;
  gatherer_->gather(x, y, taps);
  return weighted(rig_, taps, faces);
}

std::vector<double> ewa_exact_frame(const Rig& rig, std::span<const Image> faces, WorkerPool& pool) {
  const auto width = static_cast<std::size_t>(rig.frame.size.width);
  const UnroundedFilter filter(rig);
  std::vector<double> frame(width * static_cast<std::size_t>(rig.frame.size.height) * 3);
  pool.run(rig.frame.size.height, [&](int y) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::array<double, 3> rgb = filter(faces, static_cast<int>(x), y);
      std::copy(rgb.begin(), rgb.end(), frame.begin() + static_cast<std::ptrdiff_t>((y * width + x) * 3));
    }
  });
  return frame;
}

}  // namespace cupola
