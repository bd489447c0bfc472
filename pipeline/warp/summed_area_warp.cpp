// The mean over the upright rectangle around each pixel's parallelogram, by four corners of running sums, as
// in Crow's summed-area tables (1984); it stays within the pixel's own view and is cut at its edge.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "pipeline/warp/sample_store.h"
#include "pipeline/warp/slow_warp.h"

namespace cupola {
namespace {

// Sums are kept modulo 2^32. That of a rectangle is exact as long as it is below 2^32 itself: at most 256 x
// 256 texels of at most 65,535 come to 2^32 - 2^16.
constexpr int kLongestSide = 256;

// Edges of rectangles have this many bits behind the point.
constexpr int kFractionBits = 8;
constexpr int kOne = 1 << kFractionBits;

// From first to last along one axis: whole texels [begin, end), with a share of texel begin left out and one
// of texel `end` added; 2^-8 texels.
struct Extent {
  std::uint16_t begin = 0, end = 0;
  std::uint8_t left_out = 0, added = 0;
  std::int64_t length() const { return (end - begin) * kOne - left_out + added; }
};

struct Rectangle {
  Extent across, down;
  std::int16_t view = -1;  // -1: black
};

// About `centre`, at least one texel long, cut at 0 and `side`.
Extent extent(double centre, double half, int side) {
  half = std::clamp(half, 0.5, (kLongestSide - 1) / 2.0);
  const auto first = static_cast<int>(std::lround(std::clamp(centre - half, 0.0, side - 0.5) * kOne));
  const auto last =
      std::max(first + kOne / 2, static_cast<int>(std::lround(std::min<double>(centre + half, side) * kOne)));
  return {static_cast<std::uint16_t>(first / kOne), static_cast<std::uint16_t>(last / kOne),
          static_cast<std::uint8_t>(first % kOne), static_cast<std::uint8_t>(last % kOne)};
}

// Running sums of one view's needed rectangle: S(x, y) is the sum of the texels above and to the left of the
// corner (x0 + x, y0 + y).
struct Sums {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // texels
  std::size_t stride = 0;
  std::vector<std::uint32_t> sums;  // channel by channel

  std::size_t rows() const { return static_cast<std::size_t>(y1 - y0) + 1; }
  const std::uint32_t* row(int channel, int y) const {
    return sums.data() +
           (static_cast<std::size_t>(channel) * rows() + static_cast<std::size_t>(y - y0)) * stride;
  }
  std::uint32_t* row(int channel, int y) {
    return sums.data() +
           (static_cast<std::size_t>(channel) * rows() + static_cast<std::size_t>(y - y0)) * stride;
  }
};

class SummedAreaWarp final : public FrameWarp {
 public:
  SummedAreaWarp(const Rig& rig, WorkerPool& pool) : pool_(pool), width_(rig.frame.size.width) {
    rectangles_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(rig.frame.size.height));
    pool.run(rig.frame.size.height, [&](int y) {
      for (int x = 0; x < width_; ++x)
        rectangles_[static_cast<std::size_t>(y) * width_ + x] = find(rig, x, y);
    });
    for (const View& view : rig.views) needed_.push_back(NeededRegion::none(view.size));
    for (const Rectangle& r : rectangles_) {
      if (r.view >= 0) need(r);
    }
    for (const NeededRegion& region : needed_) sums_.push_back(room_for(region));
  }

  std::span<const NeededRegion> needed() const override { return needed_; }
  std::size_t table_bytes() const override { return rectangles_.size() * sizeof(Rectangle); }

  void warp(std::span<const Image> faces, const MutableImage& frame) noexcept override {
    const bool wide = faces.front().format == PixelFormat::kRgbPlanar16;
    for (std::size_t view = 0; view < faces.size(); ++view) {
      if (wide) {
        sum_up<std::uint16_t>(faces[view], view);
      } else {
        sum_up<std::uint8_t>(faces[view], view);
      }
    }
    pool_.run(frame.size.height, [&](int y) {
      for (int x = 0; x < width_; ++x) {
        const Rectangle& r = rectangles_[static_cast<std::size_t>(y) * width_ + x];
        if (r.view < 0) {
          store_pixel(frame, x, y, 1, 0, 0, 0);
          continue;
        }
        const Sums& sums = sums_[r.view];
        store_pixel(frame, x, y, wide ? 2 : 1, mean(sums, 0, r), mean(sums, 1, r), mean(sums, 2, r));
      }
    });
  }

 private:
  static Rectangle find(const Rig& rig, int x, int y) {
    Rectangle r;
    DirectionAndSlope looking;
    ViewSample at;
    if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking)) return r;
    const int home = owner(rig.views, looking.direction);
    if (home < 0 || !project(rig.views[home], looking.direction, at)) return r;
    const double wide = std::abs(glm::dot(at.du, looking.d_da)) + std::abs(glm::dot(at.du, looking.d_db));
    const double high = std::abs(glm::dot(at.dv, looking.d_da)) + std::abs(glm::dot(at.dv, looking.d_db));
    const Size size = rig.views[home].size;
    r.across = extent(at.uv.x, wide / 2, size.width);
    r.down = extent(at.uv.y, high / 2, size.height);
    r.view = static_cast<std::int16_t>(home);
    return r;
  }

  void need(const Rectangle& r) {
    NeededRegion& region = needed_[r.view];
    const int x1 = r.across.end + (r.across.added > 0 ? 1 : 0);
    const int y1 = r.down.end + (r.down.added > 0 ? 1 : 0);
    for (int y = r.down.begin; y < y1; ++y) {
      region.include(r.across.begin, y);
      region.include(x1 - 1, y);
    }
  }

  static Sums room_for(const NeededRegion& region) {
    Sums sums{region.size.width, region.size.height, 0, 0, 0, {}};
    for (int y = 0; y < region.size.height; ++y) {
      const RowSpan& row = region.rows[static_cast<std::size_t>(y)];
      if (row.empty()) continue;
      sums.x0 = std::min(sums.x0, row.first);
      sums.x1 = std::max(sums.x1, row.last);
      sums.y0 = std::min(sums.y0, y);
      sums.y1 = y + 1;
    }
    if (sums.x1 == 0) return {};
    // A corner beyond the last one is multiplied by 0 but read.
    ++sums.x1;
    ++sums.y1;
    sums.stride = static_cast<std::size_t>(sums.x1 - sums.x0) + 1;
    sums.sums.resize(3 * sums.rows() * sums.stride);
    return sums;
  }

  // Along every row first, then down every column. What is not needed counts as 0: no rectangle has any of
  // it.
  template <class Sample>
  void sum_up(const Image& face, std::size_t view) noexcept {
    Sums& sums = sums_[view];
    if (sums.sums.empty()) return;
    const NeededRegion& region = needed_[view];
    const int height = sums.y1 - sums.y0;
    pool_.run(3 * height, [&](int task) {
      const int channel = task / height;
      const int y = sums.y0 + task % height;
      const RowSpan row = y < region.size.height ? region.rows[static_cast<std::size_t>(y)] : RowSpan{};
      std::uint32_t* const out = sums.row(channel, y + 1) - sums.x0;
      std::uint32_t sum = 0;
      int x = sums.x0;
      if (!row.empty()) {
        const Sample* samples = face.samples<Sample>(channel, y);
        std::fill(out + x, out + row.first, 0U);
        for (x = row.first; x < row.last; ++x) {
          out[x] = sum;
          sum += samples[x];
        }
      }
      std::fill(out + x, out + sums.x1 + 1, sum);
    });
    constexpr int kColumns = 1024;
    const int strips = (static_cast<int>(sums.stride) + kColumns - 1) / kColumns;
    pool_.run(3 * strips, [&](int task) {
      const auto first = static_cast<std::size_t>(task % strips) * kColumns;
      const std::size_t last = std::min(sums.stride, first + kColumns);
      for (int y = sums.y0 + 1; y <= sums.y1; ++y) {
        const std::uint32_t* above = sums.row(task / strips, y - 1);
        std::uint32_t* const here = sums.row(task / strips, y);
        for (std::size_t x = first; x < last; ++x) here[x] += above[x];
      }
    });
  }

  // Nine rectangles of whole texels, each exact in 32 bits; edges count by their shares. Everything is at
  // most 2^32 * 2^16 and fits 64 bits.
  static unsigned mean(const Sums& sums, int channel, const Rectangle& r) {
    const int columns[4] = {r.across.begin, r.across.begin + 1, r.across.end, r.across.end + 1};
    const int rows[4] = {r.down.begin, r.down.begin + 1, r.down.end, r.down.end + 1};
    std::uint32_t corner[4][4];
    for (int j = 0; j < 4; ++j) {
      const std::uint32_t* row = sums.row(channel, rows[j]) - sums.x0;
      for (int i = 0; i < 4; ++i) corner[j][i] = row[columns[i]];
    }
    // Between lines a and b of corners.
    const auto between = [&](int top, int bottom) {
      const auto box = [&](int left, int right) {
        return static_cast<std::int64_t>(static_cast<std::uint32_t>(
            corner[bottom][right] - corner[top][right] - corner[bottom][left] + corner[top][left]));
      };
      return box(0, 2) * kOne - box(0, 1) * r.across.left_out + box(2, 3) * r.across.added;
    };
    const std::int64_t sum =
        between(0, 2) * kOne - between(0, 1) * r.down.left_out + between(2, 3) * r.down.added;
    const std::int64_t area = r.across.length() * r.down.length();
    return static_cast<unsigned>((2 * sum + area) / (2 * area));
  }

  WorkerPool& pool_;
  int width_;
  std::vector<Rectangle> rectangles_;
  std::vector<NeededRegion> needed_;
  std::vector<Sums> sums_;
};

}  // namespace

std::unique_ptr<FrameWarp> make_summed_area_warp(const Rig& rig, WorkerPool& pool) {
  return std::make_unique<SummedAreaWarp>(rig, pool);
}

}  // namespace cupola
