// The buffer that owns a picture, and copying between pixel formats.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/image.h"

#include <cassert>
#include <cstring>

namespace cupola {
namespace {

constexpr std::size_t kAlignment = 64;

std::size_t row_bytes(PixelFormat format, int width) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(pixel_step(format));
}

std::uint8_t to_sample(std::uint8_t value, std::uint8_t) {
  return value;
}
std::uint16_t to_sample(std::uint16_t value, std::uint16_t) {
  return value;
}
std::uint16_t to_sample(std::uint8_t value, std::uint16_t) {
  return static_cast<std::uint16_t>(value * 257);
}
// round(value / 257) for every value; the sum stays below 2^24.
std::uint8_t to_sample(std::uint16_t value, std::uint8_t) {
  return static_cast<std::uint8_t>((value * 255U + 32895U) >> 16);
}

// Where the samples of a row are: first red, green and blue, then every `kStep` samples.
template <class Sample, int kStep>
struct Row {
  Sample* red;
  Sample* green;
  Sample* blue;
};

template <class From, int kFromStep, class To, int kToStep>
void copy_row(Row<const From, kFromStep> from, Row<To, kToStep> to, int width) {
  for (int x = 0; x < width; ++x) {
    to.red[x * kToStep] = to_sample(from.red[x * kFromStep], To{});
    to.green[x * kToStep] = to_sample(from.green[x * kFromStep], To{});
    to.blue[x * kToStep] = to_sample(from.blue[x * kFromStep], To{});
  }
}

// Calls use(Row) with the samples of row `y`.
template <class Byte, class Use>
void with_row(const BasicImage<Byte>& image, int y, Use use) {
  using Sample8 = std::conditional_t<std::is_const_v<Byte>, const std::uint8_t, std::uint8_t>;
  using Sample16 = std::conditional_t<std::is_const_v<Byte>, const std::uint16_t, std::uint16_t>;
  const auto bytes = [&](int p) { return image.template samples<std::uint8_t>(p, y); };
  const auto words = [&](int p) { return image.template samples<std::uint16_t>(p, y); };
  switch (image.format) {
    case PixelFormat::kRgbPlanar8:
      return use(Row<Sample8, 1>{bytes(0), bytes(1), bytes(2)});
    case PixelFormat::kRgbPlanar16:
      return use(Row<Sample16, 1>{words(0), words(1), words(2)});
    case PixelFormat::kRgb8:
      return use(Row<Sample8, 3>{bytes(0), bytes(0) + 1, bytes(0) + 2});
    case PixelFormat::kRgb16:
      return use(Row<Sample16, 3>{words(0), words(0) + 1, words(0) + 2});
    case PixelFormat::kXrgb8888:
      return use(Row<Sample8, 4>{bytes(0) + 2, bytes(0) + 1, bytes(0)});
  }
}

}  // namespace

ImageBuffer::ImageBuffer(PixelFormat format, Size size) {
  assert(size.width >= 1 && size.width <= 65'535 && size.height >= 1 && size.height <= 65'535);
  // An odd number of cache lines: rows a power of two apart would fall into the same few sets of the cache.
  const std::size_t lines = (row_bytes(format, size.width) + kAlignment - 1) / kAlignment;
  const std::size_t stride = (lines | 1U) * kAlignment;
  // A plane's rows are followed by slack that whole-register loads may touch.
  const std::size_t plane_bytes = stride * static_cast<std::size_t>(size.height) + kAlignment;
  bytes_ = plane_bytes * static_cast<std::size_t>(plane_count(format));
  memory_.reset(static_cast<std::byte*>(::operator new (bytes_, std::align_val_t{kAlignment})));
  std::memset(memory_.get(), 0, bytes_);
  view_.format = format;
  view_.size = size;
  for (int p = 0; p < plane_count(format); ++p) {
    view_.planes[static_cast<std::size_t>(p)] = {memory_.get() + static_cast<std::size_t>(p) * plane_bytes,
                                                 static_cast<std::ptrdiff_t>(stride)};
  }
}

void convert(const Image& from, const MutableImage& to) {
  assert(from.size == to.size);
  for (int y = 0; y < to.size.height; ++y) {
    if (from.format == to.format) {
      for (std::size_t p = 0; p < static_cast<std::size_t>(plane_count(to.format)); ++p)
        std::memcpy(to.planes[p].row(y), from.planes[p].row(y), row_bytes(to.format, to.size.width));
      continue;
    }
    if (to.format == PixelFormat::kXrgb8888)
      std::memset(to.planes[0].row(y), 0xff, row_bytes(to.format, to.size.width));
    with_row(from, y, [&](auto source) {
      with_row(to, y, [&](auto target) { copy_row(source, target, to.size.width); });
    });
  }
}

}  // namespace cupola
