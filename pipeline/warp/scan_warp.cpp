// The filter as its authors ran it: a scan of the ellipse's box by finite differences, weights from a table
// indexed by Q, in floating point or in integers throughout (Greene & Heckbert 1986, the pseudocode on page
// 25).
//
// The footprint stays within the pixel's own view: at a seam the texels that exist are normalised, as in
// 1986. It knows kernels of q only: for the least-squares weights it takes the default Gaussian.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/warp/quadratic_scan.h"
#include "pipeline/warp/radial_kernel.h"
#include "pipeline/warp/sample_store.h"
#include "pipeline/warp/slow_warp.h"

namespace cupola {
namespace {

// WTAB: q from 0 to radius^2 in this many steps; "several thousand entries have proven sufficient".
constexpr int kEntries = 4096;

template <class Number>
int table_index(Number q) {
  if constexpr (std::is_integral_v<Number>) {
    return static_cast<int>(std::max<Number>(q, 0) >> kScanFractionBits);
  } else {
    return static_cast<int>(std::max<Number>(q, 0));
  }
}

// Weights: integers up to 2^16, or the kernel's own values.
template <class Number>
using Weight = std::conditional_t<std::is_integral_v<Number>, std::int64_t, float>;

// One pixel's scan: Q, which runs from 0 to kEntries within the footprint, over the texels of a box.
template <class Number>
struct Scan {
  QuadraticScan<Number> quadratic;
  std::uint16_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // the box, its last texels included
  std::int16_t view = -1;                        // -1: black
};

template <class Number>
class ScanWarp final : public FrameWarp {
 public:
  ScanWarp(const Rig& rig, WorkerPool& pool) : rig_(rig), pool_(pool), width_(rig.frame.size.width) {
    if (rig_.filter.kernel == Kernel::kOptimal) rig_.filter = default_gaussian();
    const RadialKernel kernel(rig_.filter);
    for (int i = 0; i < kEntries; ++i) {
      const double q = i * rig_.filter.radius * rig_.filter.radius / kEntries;
      const double k = kernel(q);
      table_[i] = std::is_integral_v<Number> ? static_cast<Weight<Number>>(std::llround(k * 65536.0))
                                             : static_cast<Weight<Number>>(k);
    }
    scans_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(rig.frame.size.height));
    pool.run(rig.frame.size.height, [&](int y) {
      for (int x = 0; x < width_; ++x) scans_[static_cast<std::size_t>(y) * width_ + x] = prepare(x, y);
    });
    for (const View& view : rig.views) needed_.push_back(NeededRegion::none(view.size));
    for (const Scan<Number>& scan : scans_) {
      if (scan.view < 0) continue;
      for (int y = scan.y0; y <= scan.y1; ++y) {
        needed_[scan.view].include(scan.x0, y);
        needed_[scan.view].include(scan.x1, y);
      }
    }
  }

  std::span<const NeededRegion> needed() const override { return needed_; }
  std::size_t table_bytes() const override { return scans_.size() * sizeof(Scan<Number>) + sizeof table_; }

  void warp(std::span<const Image> faces, const MutableImage& frame) noexcept override {
    const bool wide = faces.front().format == PixelFormat::kRgbPlanar16;
    pool_.run(frame.size.height, [&](int y) {
      for (int x = 0; x < width_; ++x) {
        const Scan<Number>& scan = scans_[static_cast<std::size_t>(y) * width_ + x];
        if (scan.view < 0) {
          store_pixel(frame, x, y, 1, 0, 0, 0);
        } else if (wide) {
          put<std::uint16_t>(faces[scan.view], scan, frame, x, y);
        } else {
          put<std::uint8_t>(faces[scan.view], scan, frame, x, y);
        }
      }
    });
  }

 private:
  Scan<Number> prepare(int x, int y) const {
    Scan<Number> scan{};
    DirectionAndSlope looking;
    ViewSample at;
    scan.view = -1;
    if (!ray(rig_.frame, {x + 0.5, y + 0.5}, looking)) return scan;
    const int home = owner(rig_.views, looking.direction);
    if (home < 0 || !project(rig_.views[home], looking.direction, at)) return scan;
    const double ux = glm::dot(at.du, looking.d_da);
    const double uy = glm::dot(at.du, looking.d_db);
    const double vx = glm::dot(at.dv, looking.d_da);
    const double vy = glm::dot(at.dv, looking.d_db);
    double uu = ux * ux + uy * uy;
    double vv = vx * vx + vy * vy;
    double uv = ux * vx + uy * vy;
    raise_axes(uu, uv, vv);
    uu += rig_.filter.rec;
    vv += rig_.filter.rec;
    const double radius = rig_.filter.radius;
    const double f = uu * vv - uv * uv;
    const double scale = kEntries / (f * radius * radius);
    const double a = vv * scale;
    const double b = -2.0 * uv * scale;
    const double c = uu * scale;
    const Size size = rig_.views[home].size;
    const auto texel = [](double at_most, int side) {
      return static_cast<int>(std::clamp(at_most, 0.0, side - 1.0));
    };
    scan.x0 =
        static_cast<std::uint16_t>(texel(std::ceil(at.uv.x - radius * std::sqrt(uu) - 0.5), size.width));
    scan.x1 =
        static_cast<std::uint16_t>(texel(std::floor(at.uv.x + radius * std::sqrt(uu) - 0.5), size.width));
    scan.y0 =
        static_cast<std::uint16_t>(texel(std::ceil(at.uv.y - radius * std::sqrt(vv) - 0.5), size.height));
    scan.y1 =
        static_cast<std::uint16_t>(texel(std::floor(at.uv.y + radius * std::sqrt(vv) - 0.5), size.height));
    const double u = scan.x0 + 0.5 - at.uv.x;
    const double v = scan.y0 + 0.5 - at.uv.y;
    scan.view = static_cast<std::int16_t>(home);
    scan.quadratic = scan_from<Number>(a, b, c, u, v);
    return scan;
  }

  // Raises the eigenvalues of [[uu, uv], [uv, vv]] to the square of the smallest axis.
  void raise_axes(double& uu, double& uv, double& vv) const {
    const double least = smallest_axis(rig_.filter) * smallest_axis(rig_.filter);
    const double mean = (uu + vv) / 2;
    const double spread = std::hypot((uu - vv) / 2, uv);
    if (mean - spread >= least) return;
    const double angle = std::atan2(2.0 * uv, uu - vv) / 2;  // of the larger axis
    const double large = std::max(mean + spread, least);
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    uu = large * c * c + least * s * s;
    vv = large * s * s + least * c * c;
    uv = (large - least) * c * s;
  }

  template <class Sample>
  void put(const Image& face, const Scan<Number>& scan, const MutableImage& frame, int x, int y) const {
    std::array<Weight<Number>, 3> num{};
    Weight<Number> den{};
    QuadraticScan<Number> row = scan.quadratic;
    for (int v = scan.y0; v <= scan.y1; ++v, row.down()) {
      QuadraticScan<Number> at = row;
      const Sample* red = face.samples<Sample>(0, v);
      const Sample* green = face.samples<Sample>(1, v);
      const Sample* blue = face.samples<Sample>(2, v);
      for (int u = scan.x0; u <= scan.x1; ++u, at.right()) {
        if (at.q < to_scan_number<Number>(kEntries)) {
          const Weight<Number> weight = table_[table_index(at.q)];
          num[0] += weight * static_cast<Weight<Number>>(red[u]);
          num[1] += weight * static_cast<Weight<Number>>(green[u]);
          num[2] += weight * static_cast<Weight<Number>>(blue[u]);
          den += weight;
        }
      }
    }
    std::array<unsigned, 3> rgb{};
    for (int channel = 0; channel < 3 && den > 0; ++channel) {
      if constexpr (std::is_integral_v<Number>) {
        const auto rounded = (2 * std::max<Weight<Number>>(num[channel], 0) + den) / (2 * den);
        rgb[channel] =
            static_cast<unsigned>(std::min<Weight<Number>>(rounded, static_cast<Sample>(~Sample{0})));
      } else {
        // A sum of floats may come out a little above the brightest of them.
        constexpr auto kMost = static_cast<float>(static_cast<Sample>(~Sample{0}));
        rgb[channel] = static_cast<unsigned>(std::clamp(num[channel] / den + 0.5F, 0.0F, kMost));
      }
    }
    store_pixel(frame, x, y, sizeof(Sample), rgb[0], rgb[1], rgb[2]);
  }

  Rig rig_;
  WorkerPool& pool_;
  int width_;
  std::array<Weight<Number>, kEntries> table_{};
  std::vector<Scan<Number>> scans_;
  std::vector<NeededRegion> needed_;
};

}  // namespace

std::unique_ptr<FrameWarp> make_scan_warp(const Rig& rig, Method method, WorkerPool& pool) {
  if (method == Method::kEwaScanInteger) return std::make_unique<ScanWarp<std::int64_t>>(rig, pool);
  return std::make_unique<ScanWarp<float>>(rig, pool);
}

}  // namespace cupola
