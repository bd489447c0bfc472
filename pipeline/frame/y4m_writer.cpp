// RGB to Y4M in integers.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/y4m_writer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cassert>
#include <cmath>

namespace cupola {
namespace {

AtomicFile open_output(const std::filesystem::path& path) {
  return path == "-" ? AtomicFile(STDOUT_FILENO, "standard output") : AtomicFile(path);
}

// One row of planar samples to YCbCr of 8 bits, or of 10 in words.
template <class Sample, class Out>
void to_yuv(const Image& rgb, const std::array<Out*, 3>& yuv) {
  constexpr double kRed = 0.2126, kBlue = 0.0722, kGreen = 1.0 - kRed - kBlue;  // BT.709
  constexpr int kStep = sizeof(Out) == 1 ? 1 : 4;                               // of 10 bits in one of 8
  constexpr int kShift = 32;  // sums of products stay below 4 * 219 * 2^32
  constexpr double kMost = sizeof(Sample) == 1 ? 255.0 : 65'535.0;
  const auto fixed = [](double factor) {
    return std::llround(kStep * factor / kMost * std::ldexp(1.0, kShift));
  };
  const std::int64_t luma_red = fixed(219 * kRed), luma_green = fixed(219 * kGreen),
                     luma_blue = fixed(219 * kBlue);
  const std::int64_t cb_red = fixed(-112 * kRed / (1 - kBlue)), cb_green = fixed(-112 * kGreen / (1 - kBlue));
  const std::int64_t cr_green = fixed(-112 * kGreen / (1 - kRed)), cr_blue = fixed(-112 * kBlue / (1 - kRed));
  const std::int64_t cb_blue = -cb_red - cb_green, cr_red = -cr_green - cr_blue;  // greys are exactly neutral
  const Sample* red = rgb.samples<Sample>(0, 0);
  const Sample* green = rgb.samples<Sample>(1, 0);
  const Sample* blue = rgb.samples<Sample>(2, 0);
  const auto rounded = [](std::int64_t sum, int offset) {
    return static_cast<Out>(kStep * offset + ((sum + (std::int64_t{1} << (kShift - 1))) >> kShift));
  };
  for (int x = 0; x < rgb.size.width; ++x) {
    const std::int64_t r = red[x], g = green[x], b = blue[x];
    yuv[0][x] = rounded(luma_red * r + luma_green * g + luma_blue * b, 16);
    yuv[1][x] = rounded(cb_red * r + cb_green * g + cb_blue * b, 128);
    yuv[2][x] = rounded(cr_red * r + cr_green * g + cr_blue * b, 128);
  }
}

}  // namespace

Y4mWriter::Y4mWriter(const std::filesystem::path& path, Size size, FrameRate rate, int bits)
    : file_(open_output(path)),
      size_(size),
      bits_(bits),
      planes_(std::size_t{3} * (bits > 8 ? 2 : 1) * size.width * size.height) {
  assert(bits == 8 || bits == 10);
  file_.write(fmt::format("YUV4MPEG2 W{} H{} F{}:{} Ip A1:1 C444{} XCOLORRANGE=LIMITED\n", size.width,
                          size.height, rate.numerator, rate.denominator, bits > 8 ? "p10" : ""));
}

// Samples of two bytes are little-endian, as our machines are.
template <class Out>
void Y4mWriter::write_row(int y, bool deep) {
  const std::size_t pixels = static_cast<std::size_t>(size_.width) * size_.height;
  Out* luma = reinterpret_cast<Out*>(planes_.data()) + static_cast<std::size_t>(y) * size_.width;
  const Image rgb = as_const(row_.pixels());
  if (deep) {
    to_yuv<std::uint16_t, Out>(rgb, {luma, luma + pixels, luma + 2 * pixels});
  } else {
    to_yuv<std::uint8_t, Out>(rgb, {luma, luma + pixels, luma + 2 * pixels});
  }
}

void Y4mWriter::write(const Image& image) {
  assert(image.size == size_);
  const bool deep = sample_bytes(image.format) == 2;
  const PixelFormat planar = deep ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8;
  if (row_.empty() || row_.format() != planar) row_ = ImageBuffer(planar, {size_.width, 1});
  for (int y = 0; y < size_.height; ++y) {
    convert(row_of(image, y), row_.pixels());
    if (bits_ > 8) {
      write_row<std::uint16_t>(y, deep);
    } else {
      write_row<std::uint8_t>(y, deep);
    }
  }
  file_.write("FRAME\n");
  file_.write(planes_);
}

void Y4mWriter::finish() {
  file_.commit();
}

}  // namespace cupola
