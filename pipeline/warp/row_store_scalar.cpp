// Rows into the frame, pixel by pixel.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "pipeline/warp/light.h"
#include "pipeline/warp/row_store_wide.h"

namespace cupola {
namespace {

template <class To, class From>
To as(From sample) {
  if constexpr (sizeof(To) == sizeof(From)) {
    return sample;
  } else {
    static_assert(sizeof(To) == 2);
    return static_cast<To>(sample * 257);
  }
}

std::array<std::uint8_t, 3> rgb(Xrgb pixel) {
  return {static_cast<std::uint8_t>(pixel >> 16), static_cast<std::uint8_t>(pixel >> 8),
          static_cast<std::uint8_t>(pixel)};
}
std::array<std::uint16_t, 3> rgb(Rgb16 pixel) {
  return {pixel.r, pixel.g, pixel.b};
}

template <class To, class Pixel>
void store_planar(const Pixel* pixels, int count, const MutableImage& frame, int x, int y) {
  for (int channel = 0; channel < 3; ++channel) {
    To* out = frame.samples<To>(channel, y) + x;
    for (int i = 0; i < count; ++i) out[i] = as<To>(rgb(pixels[i])[channel]);
  }
}

template <class To, class Pixel>
void store_interleaved(const Pixel* pixels, int count, const MutableImage& frame, int x, int y) {
  To* out = frame.samples<To>(0, y) + x * 3;
  for (int i = 0; i < count; ++i) {
    for (const auto sample : rgb(pixels[i])) *out++ = as<To>(sample);
  }
}

}  // namespace

void store_row_scalar(const Xrgb* pixels, int count, const MutableImage& frame, int x, int y) noexcept {
  switch (frame.format) {
    case PixelFormat::kRgbPlanar8:
      return store_planar<std::uint8_t>(pixels, count, frame, x, y);
    case PixelFormat::kRgbPlanar16:
      return store_planar<std::uint16_t>(pixels, count, frame, x, y);
    case PixelFormat::kRgb8:
      return store_interleaved<std::uint8_t>(pixels, count, frame, x, y);
    case PixelFormat::kRgb16:
      return store_interleaved<std::uint16_t>(pixels, count, frame, x, y);
    case PixelFormat::kXrgb8888:
      std::copy_n(pixels, count, frame.samples<Xrgb>(0, y) + x);
  }
}

void store_row_deep(const Rgb16* pixels, int count, const MutableImage& frame, int x, int y) noexcept {
  if (frame.format == PixelFormat::kRgb16) {
    store_interleaved<std::uint16_t>(pixels, count, frame, x, y);
  } else {
    store_planar<std::uint16_t>(pixels, count, frame, x, y);
  }
}

void store_row_deep_light(const Rgb16* pixels, int count, const MutableImage& frame, int x, int y) noexcept {
  const auto& srgb = light_tables().srgb16_of_light;
  for (int i = 0; i < count; ++i) {
    const Rgb16 pixel{srgb[pixels[i].r], srgb[pixels[i].g], srgb[pixels[i].b], 0};
    store_row_deep(&pixel, 1, frame, x + i, y);
  }
}

void finish_rows_scalar() noexcept {}

}  // namespace cupola
