// Rows into the frame, pixel by pixel.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/row_store.h"

namespace cupola {
namespace {

template <class To, class From>
To as(From sample) {
  if constexpr (sizeof(To) == sizeof(From)) {
    return sample;
  } else if constexpr (sizeof(To) == 2) {
    return static_cast<To>(sample * 257);
  } else {
    return static_cast<To>((sample * 255U + 32767U) / 65535U);
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

template <class Pixel>
void store_xrgb(const Pixel* pixels, int count, const MutableImage& frame, int x, int y) {
  Xrgb* out = frame.samples<Xrgb>(0, y) + x;
  for (int i = 0; i < count; ++i) {
    const auto [r, g, b] = rgb(pixels[i]);
    out[i] =
        kBlackXrgb | Xrgb{as<std::uint8_t>(r)} << 16 | Xrgb{as<std::uint8_t>(g)} << 8 | as<std::uint8_t>(b);
  }
}

template <class Pixel>
void store_row(const Pixel* pixels, int count, const MutableImage& frame, int x, int y) {
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
      return store_xrgb(pixels, count, frame, x, y);
  }
}

}  // namespace

void store_row_scalar(const Xrgb* pixels, int count, const MutableImage& frame, int x, int y) noexcept {
  store_row(pixels, count, frame, x, y);
}

void store_row_wide(const Rgb16* pixels, int count, const MutableImage& frame, int x, int y) noexcept {
  store_row(pixels, count, frame, x, y);
}

void finish_rows_scalar() noexcept {}

}  // namespace cupola
