// Point sampling and bilinear interpolation from per-pixel positions found once; they clamp at a view's edge.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "pipeline/warp/sample_store.h"
#include "pipeline/warp/slow_warp.h"

namespace cupola {
namespace {

struct Position {
  float u, v;  // texels
  int view;    // -1: black
};

class PointWarp final : public FrameWarp {
 public:
  PointWarp(const Rig& rig, bool bilinear, WorkerPool& pool)
      : rig_(rig), bilinear_(bilinear), pool_(pool), width_(rig.frame.size.width) {
    positions_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(rig.frame.size.height));
    pool.run(rig.frame.size.height, [&](int y) {
      for (int x = 0; x < width_; ++x) positions_[static_cast<std::size_t>(y) * width_ + x] = find(x, y);
    });
    for (const View& view : rig.views) needed_.push_back(NeededRegion::none(view.size));
    for (const Position& p : positions_) {
      if (p.view >= 0) need(p);
    }
  }

  std::span<const NeededRegion> needed() const override { return needed_; }
  std::size_t table_bytes() const override { return positions_.size() * sizeof(Position); }

  void warp(std::span<const Image> faces, const MutableImage& frame) noexcept override {
    const bool wide = faces.front().format == PixelFormat::kRgbPlanar16;
    pool_.run(frame.size.height, [&](int y) {
      for (int x = 0; x < width_; ++x) {
        const Position& p = positions_[static_cast<std::size_t>(y) * width_ + x];
        if (p.view < 0) {
          store_pixel(frame, x, y, 1, 0, 0, 0);
        } else if (wide) {
          put<std::uint16_t>(faces[p.view], p, frame, x, y);
        } else {
          put<std::uint8_t>(faces[p.view], p, frame, x, y);
        }
      }
    });
  }

 private:
  Position find(int x, int y) const {
    DirectionAndSlope looking;
    Vec2 uv;
    if (!ray(rig_.frame, {x + 0.5, y + 0.5}, looking)) return {0, 0, -1};
    const int view = owner(rig_.views, looking.direction);
    if (view < 0 || !project(rig_.views[view], looking.direction, uv)) return {0, 0, -1};
    return {static_cast<float>(uv.x), static_cast<float>(uv.y), view};
  }

  // The texel (column, row) and for bilinear its right and lower neighbours, clamped, with their shares.
  struct Corner {
    int x0, x1, y0, y1;
    float fx, fy;
  };
  Corner corner(const Position& p) const {
    const Size size = rig_.views[p.view].size;
    const float u = bilinear_ ? p.u - 0.5F : p.u;
    const float v = bilinear_ ? p.v - 0.5F : p.v;
    const int x = static_cast<int>(std::floor(u));
    const int y = static_cast<int>(std::floor(v));
    const auto clamp_x = [&](int i) { return std::clamp(i, 0, size.width - 1); };
    const auto clamp_y = [&](int i) { return std::clamp(i, 0, size.height - 1); };
    return {clamp_x(x),
            clamp_x(x + 1),
            clamp_y(y),
            clamp_y(y + 1),
            u - static_cast<float>(x),
            v - static_cast<float>(y)};
  }

  void need(const Position& p) {
    const Corner c = corner(p);
    NeededRegion& region = needed_[p.view];
    region.include(c.x0, c.y0);
    if (!bilinear_) return;
    region.include(c.x1, c.y0);
    region.include(c.x0, c.y1);
    region.include(c.x1, c.y1);
  }

  template <class Sample>
  void put(const Image& face, const Position& p, const MutableImage& frame, int x, int y) const {
    const Corner c = corner(p);
    std::array<unsigned, 3> rgb{};
    for (int channel = 0; channel < 3; ++channel) {
      const Sample* top = face.samples<Sample>(channel, c.y0);
      if (!bilinear_) {
        rgb[channel] = top[c.x0];
        continue;
      }
      const Sample* bottom = face.samples<Sample>(channel, c.y1);
      const double upper = top[c.x0] + (static_cast<double>(top[c.x1]) - top[c.x0]) * c.fx;
      const double lower = bottom[c.x0] + (static_cast<double>(bottom[c.x1]) - bottom[c.x0]) * c.fx;
      rgb[channel] = static_cast<unsigned>(upper + (lower - upper) * c.fy + 0.5);
    }
    store_pixel(frame, x, y, sizeof(Sample), rgb[0], rgb[1], rgb[2]);
  }

  const Rig rig_;
  bool bilinear_;
  WorkerPool& pool_;
  int width_;
  std::vector<Position> positions_;
  std::vector<NeededRegion> needed_;
};

}  // namespace

std::unique_ptr<FrameWarp> make_point_warp(const Rig& rig, Method method, WorkerPool& pool) {
  return std::make_unique<PointWarp>(rig, method == Method::kBilinear, pool);
}

}  // namespace cupola
