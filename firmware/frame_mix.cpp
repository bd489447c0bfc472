// One loop over the samples of a row, whatever they are; the compiler makes vectors of it.
// SPDX-License-Identifier: MIT
#include "firmware/frame_mix.h"

#include <algorithm>
#include <cstddef>

namespace cupola {
namespace {

constexpr int kRowsATask = 16;

// d = b - a is in [-65535, 65535], the weight in [0, 2^15]: |d * weight| <= 65535 * 2^15 = 2^31 - 2^15, and
// with 2^14 added below 2^31. Shifting an int right rounds down, so this is floor(x + 1/2) of the exact value
// x, which lies between a and b: it fits the sample again.
template <class Sample>
void mix_row(const Sample* a, const Sample* b, std::int32_t weight, Sample* into,
             std::ptrdiff_t count) noexcept {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::int32_t from = a[i];
    into[i] = static_cast<Sample>(from + (((b[i] - from) * weight + (1 << 14)) >> 15));
  }
}

template <class Sample>
void mix_rows(const Image& a, const Image& b, std::int32_t weight, const MutableImage& into, int first,
              int last) noexcept {
  const std::ptrdiff_t samples =
      std::ptrdiff_t{into.size.width} * pixel_step(into.format) / static_cast<int>(sizeof(Sample));
  for (int p = 0; p < plane_count(into.format); ++p) {
    for (int y = first; y < last; ++y) {
      mix_row(a.samples<Sample>(p, y), b.samples<Sample>(p, y), weight, into.samples<Sample>(p, y), samples);
    }
  }
}

}  // namespace

void mix(const Image& a, const Image& b, std::int32_t weight, const MutableImage& into,
         WorkerPool& pool) noexcept {
  const int height = into.size.height;
  pool.run((height + kRowsATask - 1) / kRowsATask, [&](int task) {
    const int first = task * kRowsATask;
    const int last = std::min(height, first + kRowsATask);
    if (sample_bytes(into.format) == 2) {
      mix_rows<std::uint16_t>(a, b, weight, into, first, last);
    } else {
      mix_rows<std::uint8_t>(a, b, weight, into, first, last);
    }
  });
}

// 255 * 2^15 + 2^14 < 2^23.
void dim(const Image& b, std::int32_t weight, const MutableImage& into, WorkerPool& pool) noexcept {
  const auto share = static_cast<std::uint32_t>(weight);
  const int height = into.size.height;
  pool.run((height + kRowsATask - 1) / kRowsATask, [&](int task) {
    for (int y = task * kRowsATask; y < std::min(height, (task + 1) * kRowsATask); ++y) {
      const auto* from = b.samples<std::uint32_t>(0, y);
      auto* to = into.samples<std::uint32_t>(0, y);
      for (int x = 0; x < into.size.width; ++x) {
        const std::uint32_t red = ((from[x] >> 16 & 255U) * share + (1U << 14)) >> 15;
        const std::uint32_t green = ((from[x] >> 8 & 255U) * share + (1U << 14)) >> 15;
        const std::uint32_t blue = ((from[x] & 255U) * share + (1U << 14)) >> 15;
        to[x] = 0xff000000U | red << 16 | green << 8 | blue;
      }
    }
  });
}

void blacken(const MutableImage& image) noexcept {
  for (int p = 0; p < plane_count(image.format); ++p) {
    for (int y = 0; y < image.size.height; ++y) {
      if (image.format == PixelFormat::kXrgb8888) {
        std::fill_n(image.samples<std::uint32_t>(p, y), image.size.width, 0xff000000U);
      } else {
        std::fill_n(image.planes[static_cast<std::size_t>(p)].row(y),
                    std::ptrdiff_t{image.size.width} * pixel_step(image.format), std::byte{0});
      }
    }
  }
}

}  // namespace cupola
