// RGB to Y4M in integers.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/y4m_writer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cassert>
#include <cmath>

namespace cupola {
namespace {

AtomicFile open_output(const std::filesystem::path& path) {
  return path == "-" ? AtomicFile(STDOUT_FILENO, "standard output") : AtomicFile(path);
}

// One row of planar samples to 8-bit YCbCr.
template <class Sample>
void to_yuv(const Image& rgb, std::byte* luma, std::byte* cb, std::byte* cr) {
  constexpr double kRed = 0.2126, kBlue = 0.0722, kGreen = 1.0 - kRed - kBlue;  // BT.709
  constexpr int kShift = 32;  // sums of products stay below 65,535 * 2^32 * 1
  constexpr double kMost = sizeof(Sample) == 1 ? 255.0 : 65'535.0;
  const auto fixed = [](double factor) { return std::llround(factor / kMost * std::ldexp(1.0, kShift)); };
  const std::int64_t luma_red = fixed(219 * kRed), luma_green = fixed(219 * kGreen),
                     luma_blue = fixed(219 * kBlue);
  const std::int64_t cb_red = fixed(-112 * kRed / (1 - kBlue)), cb_green = fixed(-112 * kGreen / (1 - kBlue));
  const std::int64_t cr_green = fixed(-112 * kGreen / (1 - kRed)), cr_blue = fixed(-112 * kBlue / (1 - kRed));
  const std::int64_t cb_blue = -cb_red - cb_green, cr_red = -cr_green - cr_blue;  // greys are exactly neutral
  const Sample* red = rgb.samples<Sample>(0, 0);
  const Sample* green = rgb.samples<Sample>(1, 0);
  const Sample* blue = rgb.samples<Sample>(2, 0);
  const auto rounded = [](std::int64_t sum, int offset) {
    return static_cast<std::byte>(offset + ((sum + (std::int64_t{1} << (kShift - 1))) >> kShift));
  };
  for (int x = 0; x < rgb.size.width; ++x) {
    const std::int64_t r = red[x], g = green[x], b = blue[x];
    luma[x] = rounded(luma_red * r + luma_green * g + luma_blue * b, 16);
    cb[x] = rounded(cb_red * r + cb_green * g + cb_blue * b, 128);
    cr[x] = rounded(cr_red * r + cr_green * g + cr_blue * b, 128);
  }
}

}  // namespace

Y4mWriter::Y4mWriter(const std::filesystem::path& path, Size size, FrameRate rate)
    : file_(open_output(path)), size_(size), planes_(std::size_t{3} * size.width * size.height) {
  file_.write(fmt::format("YUV4MPEG2 W{} H{} F{}:{} Ip A1:1 C444 XCOLORRANGE=LIMITED\n", size.width,
                          size.height, rate.numerator, rate.denominator));
}

void Y4mWriter::write(const Image& image) {
  assert(image.size == size_);
  const bool deep = sample_bytes(image.format) == 2;
  const PixelFormat planar = deep ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8;
  if (row_.empty() || row_.format() != planar) row_ = ImageBuffer(planar, {size_.width, 1});
  const std::size_t pixels = static_cast<std::size_t>(size_.width) * size_.height;
  for (int y = 0; y < size_.height; ++y) {
    convert(row_of(image, y), row_.pixels());
    std::byte* luma = planes_.data() + static_cast<std::size_t>(y) * size_.width;
    const Image rgb = as_const(row_.pixels());
    if (deep) {
      to_yuv<std::uint16_t>(rgb, luma, luma + pixels, luma + 2 * pixels);
    } else {
      to_yuv<std::uint8_t>(rgb, luma, luma + pixels, luma + 2 * pixels);
    }
  }
  file_.write("FRAME\n");
  file_.write(planes_);
}

void Y4mWriter::finish() {
  file_.commit();
}

}  // namespace cupola
