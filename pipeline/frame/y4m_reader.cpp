// Y4M to RGB in integers.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/y4m_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

constexpr std::string_view kFrameLine = "FRAME\n";
constexpr double kRed = 0.2126, kBlue = 0.0722, kGreen = 1.0 - kRed - kBlue;  // BT.709

// RGB of `most` at white = (luma * (Y - black) + chroma * C) >> shift, where C is 16 times the chroma about
// its zero.
struct Matrix {
  std::int64_t black, chroma_zero;  // in stored steps
  std::int64_t luma, red_cr, green_cb, green_cr, blue_cb;
};

Matrix make_matrix(const Y4mHeader& header, int most, int shift) {
  const double largest = std::ldexp(1.0, header.bits) - 1.0;
  const double scale = std::ldexp(1.0, header.bits - 8);
  const double luma_range = header.full_range ? largest : 219.0 * scale;
  const double chroma_range = header.full_range ? largest : 224.0 * scale;
  const auto fixed = [&](double factor, int bits) {
    return std::llround(factor * most * std::ldexp(1.0, bits));
  };
  Matrix matrix{};
  matrix.black = header.full_range ? 0 : std::int64_t{16} << (header.bits - 8);
  matrix.chroma_zero = std::int64_t{1} << (header.bits - 1);
  matrix.luma = fixed(1.0 / luma_range, shift);
  matrix.red_cr = fixed(2.0 * (1.0 - kRed) / chroma_range, shift - 4);
  matrix.blue_cb = fixed(2.0 * (1.0 - kBlue) / chroma_range, shift - 4);
  matrix.green_cb = fixed(2.0 * (1.0 - kBlue) * kBlue / kGreen / chroma_range, shift - 4);
  matrix.green_cr = fixed(2.0 * (1.0 - kRed) * kRed / kGreen / chroma_range, shift - 4);
  return matrix;
}

template <class Sample>
std::int32_t sample_at(const std::byte* row, int x) {
  if constexpr (sizeof(Sample) == 1) return std::to_integer<std::int32_t>(row[x]);
  return std::to_integer<std::int32_t>(row[2 * x]) | std::to_integer<std::int32_t>(row[2 * x + 1]) << 8;
}

}  // namespace

Y4mReader::Y4mReader(const std::filesystem::path& path) : file_(path, "a Y4M video"), name_(path.string()) {
  char start[kLongestY4mHeader];
  const auto count = static_cast<std::size_t>(std::min<std::int64_t>(file_.size(), kLongestY4mHeader));
  file_.read_at(0, start, count);
  header_ = parse_y4m_header({start, count}, name_);

  const std::int64_t each = static_cast<std::int64_t>(kFrameLine.size()) + header_.frame_bytes();
  const std::int64_t all = file_.size() - static_cast<std::int64_t>(header_.bytes);
  frames_ = all / each;
  const std::int64_t left = all % each;
  // A frame line with parameters would also upset the count, so the first one is looked at before it is
  // blamed.
  if (all > 0) {
    char line[kFrameLine.size() + 1] = {};
    const auto shown = std::min<std::int64_t>(all, kFrameLine.size());
    file_.read_at(static_cast<std::int64_t>(header_.bytes), line, static_cast<std::size_t>(shown));
    if (std::string_view(line) == "FRAME ") {
      throw InputError(
          fmt::format("{}: its frames have parameters of their own; expected a bare FRAME line", name_));
    }
  }
  if (frames_ == 0 || left != 0) {
    throw InputError(fmt::format("{}: the Y4M video ends within frame {}; expected {} bytes a frame", name_,
                                 frames_, header_.frame_bytes()));
  }
  const auto chroma_bytes = static_cast<std::size_t>(header_.chroma_bytes());
  luma_.resize(static_cast<std::size_t>(header_.luma_bytes()));
  for (auto& plane : chroma_) plane.resize(chroma_bytes);
  column_.resize(static_cast<std::size_t>(header_.chroma_width()));
  for (auto& row : interpolated_) row.resize(static_cast<std::size_t>(header_.size.width));
  row_ = ImageBuffer(format(), {header_.size.width, 1});
}

void Y4mReader::read(std::int64_t frame, const MutableImage& into, RowRange rows) {
  if (into.size != header_.size) {
    throw InputError(fmt::format("{}: the video is {} x {}; expected {} x {}", name_, header_.size.width,
                                 header_.size.height, into.size.width, into.size.height));
  }
  if (frame < 0 || frame >= frames_) {
    throw InputError(fmt::format("{}: frame {} asked for; it has frames 0 to {}", name_, frame, frames_ - 1));
  }
  rows = rows.within(header_.size.height);
  if (rows.empty()) return;
  std::int64_t at = static_cast<std::int64_t>(header_.bytes) +
                    frame * (static_cast<std::int64_t>(kFrameLine.size()) + header_.frame_bytes());
  char line[kFrameLine.size()];
  file_.read_at(at, line, sizeof line);
  if (std::string_view(line, sizeof line) != kFrameLine) {
    throw InputError(fmt::format("{}: frame {} does not begin with a bare FRAME line", name_, frame));
  }
  at += static_cast<std::int64_t>(sizeof line);

  const auto fetch_rows = [&](std::vector<std::byte>& to, RowRange wanted, int width) {
    const std::int64_t row_bytes = std::int64_t{width} * header_.bytes_per_sample();
    file_.read_at(at + wanted.first * row_bytes, to.data(),
                  static_cast<std::size_t>((wanted.last - wanted.first) * row_bytes));
  };
  fetch_rows(luma_, rows, header_.size.width);
  at += header_.luma_bytes();
  const int shift = header_.chroma_shift_y;
  const RowRange chroma_rows =  // one more above and below to interpolate from
      shift == 0 ? rows
                 : RowRange{(rows.first >> 1) - 1, (rows.last >> 1) + 1}.within(header_.chroma_height());
  if (header_.colour) {
    for (auto& plane : chroma_) {
      fetch_rows(plane, chroma_rows, header_.chroma_width());
      at += header_.chroma_bytes();
    }
  }
  if (header_.bits > 8) {
    convert_rows<std::uint16_t>(into, rows, chroma_rows);
  } else {
    convert_rows<std::uint8_t>(into, rows, chroma_rows);
  }
}

template <class Sample>
void Y4mReader::interpolate_chroma(int plane, int y, RowRange chroma_rows) {
  const auto p = static_cast<std::size_t>(plane);
  const int width = header_.chroma_width();
  const auto row_at = [&](int row) {
    row = std::clamp(row, chroma_rows.first, chroma_rows.last - 1);
    return chroma_[p].data() + static_cast<std::size_t>(row - chroma_rows.first) *
                                   static_cast<std::size_t>(width) * sizeof(Sample);
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
  const Taps down = taps(y, header_.chroma_shift_y, header_.siting_y);
  const std::byte* near = row_at(down.near);
  const std::byte* far = row_at(down.far);
  std::int32_t* column = column_.data();
  for (int x = 0; x < width; ++x) {
    column[x] = down.weight * sample_at<Sample>(near, x) + (4 - down.weight) * sample_at<Sample>(far, x);
  }
  std::int32_t* out = interpolated_[p].data();
  if (header_.chroma_shift_x == 0) {
    for (int x = 0; x < width; ++x) out[x] = 4 * column[x];
    return;
  }
  for (int x = 0; x < header_.size.width; ++x) {
    const Taps across = taps(x, 1, header_.siting_x);
    out[x] = across.weight * column[across.near] +
             (4 - across.weight) * column[std::clamp(across.far, 0, width - 1)];
  }
}

template <class Sample>
void Y4mReader::convert_rows(const MutableImage& into, RowRange rows, RowRange chroma_rows) {
  // 8 bits: |Y - black| < 2^8, luma < 1.17 * 2^20, |C| <= 2^11, factors < 2.12 * 2^16: every sum is below
  // 2^31. Above 8 bits: stored values below 2^16 whatever the header says, luma < 150 * 2^28, factors <
  // 280 * 2^24 times |C| <= 2^20: every sum is below 2^54.
  using Wide = std::conditional_t<sizeof(Sample) == 1, std::int32_t, std::int64_t>;
  constexpr int kShift = sizeof(Sample) == 1 ? 20 : 28;
  constexpr Wide kMost = std::numeric_limits<Sample>::max();
  const Matrix matrix = make_matrix(header_, static_cast<int>(kMost), kShift);
  const auto black = static_cast<Wide>(matrix.black);
  const auto zero = static_cast<Wide>(16 * matrix.chroma_zero);
  const auto luma = static_cast<Wide>(matrix.luma);
  const auto red_cr = static_cast<Wide>(matrix.red_cr), green_cr = static_cast<Wide>(matrix.green_cr);
  const auto blue_cb = static_cast<Wide>(matrix.blue_cb), green_cb = static_cast<Wide>(matrix.green_cb);
  const auto rounded = [](Wide sum) {
    const Wide nearest = (sum + (Wide{1} << (kShift - 1))) >> kShift;
    return static_cast<Sample>(nearest < 0 ? 0 : nearest > kMost ? kMost : nearest);
  };
  const int width = header_.size.width;
  const MutableImage& rgb = row_.pixels();
  auto* red = rgb.template samples<Sample>(0, 0);
  auto* green = rgb.template samples<Sample>(1, 0);
  auto* blue = rgb.template samples<Sample>(2, 0);
  const std::int32_t* cb_row = interpolated_[0].data();
  const std::int32_t* cr_row = interpolated_[1].data();
  for (int y = rows.first; y < rows.last; ++y) {
    const std::byte* stored = luma_.data() + static_cast<std::size_t>(y - rows.first) *
                                                 static_cast<std::size_t>(width) * sizeof(Sample);
    if (header_.colour) {
      interpolate_chroma<Sample>(0, y, chroma_rows);
      interpolate_chroma<Sample>(1, y, chroma_rows);
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
    convert(as_const(rgb), row_of(into, y));
  }
}

}  // namespace cupola
