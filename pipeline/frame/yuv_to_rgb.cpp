// Luma and chroma to RGB in integers.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/yuv_to_rgb.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace cupola {
namespace {

// RGB of `most` at white = (luma * (Y - black) + chroma * C) >> shift, where C is 16 times the chroma about
// its zero.
struct Matrix {
  std::int64_t black, chroma_zero;  // in stored steps
  std::int64_t luma, red_cr, green_cb, green_cr, blue_cb;
};

Matrix make_matrix(const PlanarVideo& video, int most, int shift) {
  const double red = video.weights.red;
  const double blue = video.weights.blue;
  const double green = 1.0 - red - blue;
  const double largest = std::ldexp(1.0, video.bits) - 1.0;
  const double scale = std::ldexp(1.0, video.bits - 8);
  const double luma_range = video.full_range ? largest : 219.0 * scale;
  const double chroma_range = video.full_range ? largest : 224.0 * scale;
  const auto fixed = [&](double factor, int bits) {
    return std::llround(factor * most * std::ldexp(1.0, bits));
  };
  Matrix matrix{};
  matrix.black = video.full_range ? 0 : std::int64_t{16} << (video.bits - 8);
  matrix.chroma_zero = std::int64_t{1} << (video.bits - 1);
  matrix.luma = fixed(1.0 / luma_range, shift);
  matrix.red_cr = fixed(2.0 * (1.0 - red) / chroma_range, shift - 4);
  matrix.blue_cb = fixed(2.0 * (1.0 - blue) / chroma_range, shift - 4);
  matrix.green_cb = fixed(2.0 * (1.0 - blue) * blue / green / chroma_range, shift - 4);
  matrix.green_cr = fixed(2.0 * (1.0 - red) * red / green / chroma_range, shift - 4);
  return matrix;
}

template <class Sample>
std::int32_t sample_at(const std::byte* row, int x) {
  if constexpr (sizeof(Sample) == 1) return std::to_integer<std::int32_t>(row[x]);
  return std::to_integer<std::int32_t>(row[2 * x]) | std::to_integer<std::int32_t>(row[2 * x + 1]) << 8;
}

}  // namespace

YuvToRgb::YuvToRgb(const PlanarVideo& video)
    : video_(video),
      row_(video.bits > 8 ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8, {video.size.width, 1}) {
  column_.resize(static_cast<std::size_t>(video.chroma_width()));
  for (auto& row : interpolated_) row.resize(static_cast<std::size_t>(video.size.width));
}

RowRange YuvToRgb::chroma_rows(RowRange rows) const {
  if (video_.chroma_shift_y == 0) return rows;
  return RowRange{(rows.first >> 1) - 1, (rows.last >> 1) + 1}.within(video_.chroma_height());
}

void YuvToRgb::convert(const std::array<Plane<const std::byte>, 3>& planes, RowRange rows,
                       const MutableImage& into) {
  if (video_.bits > 8) {
    convert_rows<std::uint16_t>(planes, rows, into);
  } else {
    convert_rows<std::uint8_t>(planes, rows, into);
  }
}

template <class Sample>
void YuvToRgb::interpolate_chroma(const Plane<const std::byte>& plane, std::size_t p, int y,
                                  RowRange chroma_rows) {
  const int width = video_.chroma_width();
  const auto row_at = [&](int row) {
    row = std::clamp(row, chroma_rows.first, chroma_rows.last - 1);
    return plane.row(row - chroma_rows.first);
  };
  // Two neighbours and the near one's weight in quarters. Between: 3/4 and 1/4 of the next on the pixel's
  // side. On the first: all of it on even pixels, halves on odd ones.
  struct Taps {
    int near, far, weight;
  };
  const auto taps = [](int pixel, int shifted, Siting siting) -> Taps {
    const int own = pixel >> shifted;
    if (shifted == 0) return {own, own, 4};
    if (siting == Siting::kBetween) return {own, (pixel & 1) != 0 ? own + 1 : own - 1, 3};
    return {own, own + 1, (pixel & 1) != 0 ? 2 : 4};
  };
  const Taps down = taps(y, video_.chroma_shift_y, video_.siting_y);
  const std::byte* near = row_at(down.near);
  const std::byte* far = row_at(down.far);
  std::int32_t* column = column_.data();
  for (int x = 0; x < width; ++x) {
    column[x] = down.weight * sample_at<Sample>(near, x) + (4 - down.weight) * sample_at<Sample>(far, x);
  }
  std::int32_t* out = interpolated_[p].data();
  if (video_.chroma_shift_x == 0) {
    for (int x = 0; x < width; ++x) out[x] = 4 * column[x];
    return;
  }
  for (int x = 0; x < video_.size.width; ++x) {
    const Taps across = taps(x, 1, video_.siting_x);
    out[x] = across.weight * column[across.near] +
             (4 - across.weight) * column[std::clamp(across.far, 0, width - 1)];
  }
}

template <class Sample>
void YuvToRgb::convert_rows(const std::array<Plane<const std::byte>, 3>& planes, RowRange rows,
                            const MutableImage& into) {
  const RowRange chroma = chroma_rows(rows);
  // 8 bits: |Y - black| < 2^8, luma < 1.17 * 2^20, |C| <= 2^11, factors < 2.12 * 2^16: every sum is below
  // 2^31. Above 8 bits: stored values below 2^16 whatever the header says, luma < 150 * 2^28, factors <
  // 280 * 2^24 times |C| <= 2^20: every sum is below 2^54.
  using Wide = std::conditional_t<sizeof(Sample) == 1, std::int32_t, std::int64_t>;
  constexpr int kShift = sizeof(Sample) == 1 ? 20 : 28;
  constexpr Wide kMost = std::numeric_limits<Sample>::max();
  const Matrix matrix = make_matrix(video_, static_cast<int>(kMost), kShift);
  const auto black = static_cast<Wide>(matrix.black);
  const auto zero = static_cast<Wide>(16 * matrix.chroma_zero);
  const auto luma = static_cast<Wide>(matrix.luma);
  const auto red_cr = static_cast<Wide>(matrix.red_cr), green_cr = static_cast<Wide>(matrix.green_cr);
  const auto blue_cb = static_cast<Wide>(matrix.blue_cb), green_cb = static_cast<Wide>(matrix.green_cb);
  const auto rounded = [](Wide sum) {
    const Wide nearest = (sum + (Wide{1} << (kShift - 1))) >> kShift;
    return static_cast<Sample>(nearest < 0 ? 0 : nearest > kMost ? kMost : nearest);
  };
  const int width = video_.size.width;
  const MutableImage& rgb = row_.pixels();
  auto* red = rgb.template samples<Sample>(0, 0);
  auto* green = rgb.template samples<Sample>(1, 0);
  auto* blue = rgb.template samples<Sample>(2, 0);
  const std::int32_t* cb_row = interpolated_[0].data();
  const std::int32_t* cr_row = interpolated_[1].data();
  for (int y = rows.first; y < rows.last; ++y) {
    const std::byte* stored = planes[0].row(y - rows.first);
    if (video_.colour) {
      interpolate_chroma<Sample>(planes[1], 0, y, chroma);
      interpolate_chroma<Sample>(planes[2], 1, y, chroma);
      for (int x = 0; x < width; ++x) {
        const Wide grey = luma * (sample_at<Sample>(stored, x) - black);
        const Wide cb = cb_row[x] - zero;
        const Wide cr = cr_row[x] - zero;
        red[x] = rounded(grey + red_cr * cr);
        green[x] = rounded(grey - green_cb * cb - green_cr * cr);
        blue[x] = rounded(grey + blue_cb * cb);
      }
    } else {
      for (int x = 0; x < width; ++x) {
        red[x] = green[x] = blue[x] = rounded(luma * (sample_at<Sample>(stored, x) - black));
      }
    }
    cupola::convert(as_const(rgb), row_of(into, y));
  }
}

}  // namespace cupola
