// Rows of a tile into the frame.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/tile_store.h"

#include <algorithm>
#include <cstring>

namespace cupola {
namespace {

template <class Sample>
const Sample* tile_row(const TilePixels<Sample>& pixels, int channel, int row) {
  return pixels.channel[static_cast<std::size_t>(channel)].data() + row * kTileSide;
}

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

template <class To, class From>
void store_planar(const TilePixels<From>& pixels, int y, int x, int width, const MutableImage& frame,
                  int row) {
  for (int channel = 0; channel < 3; ++channel) {
    const From* samples = tile_row(pixels, channel, row);
    To* out = frame.samples<To>(channel, y) + x;
    if constexpr (sizeof(To) == sizeof(From)) {
      std::memcpy(out, samples, static_cast<std::size_t>(width) * sizeof(To));
    } else {
      for (int i = 0; i < width; ++i) out[i] = as<To>(samples[i]);
    }
  }
}

template <class To, class From>
void store_interleaved(const TilePixels<From>& pixels, int y, int x, int width, const MutableImage& frame,
                       int row) {
  const From* red = tile_row(pixels, 0, row);
  const From* green = tile_row(pixels, 1, row);
  const From* blue = tile_row(pixels, 2, row);
  To* out = frame.samples<To>(0, y) + x * 3;
  for (int i = 0; i < width; ++i, out += 3) {
    out[0] = as<To>(red[i]);
    out[1] = as<To>(green[i]);
    out[2] = as<To>(blue[i]);
  }
}

template <class From>
void store_xrgb(const TilePixels<From>& pixels, int y, int x, int width, const MutableImage& frame, int row) {
  const From* red = tile_row(pixels, 0, row);
  const From* green = tile_row(pixels, 1, row);
  const From* blue = tile_row(pixels, 2, row);
  auto* out = frame.samples<std::uint32_t>(0, y) + x;
  for (int i = 0; i < width; ++i) {
    out[i] = 0xff000000U | static_cast<std::uint32_t>(as<std::uint8_t>(red[i])) << 16 |
             static_cast<std::uint32_t>(as<std::uint8_t>(green[i])) << 8 | as<std::uint8_t>(blue[i]);
  }
}

template <class From>
void store(const TilePixels<From>& pixels, int x, int y, const MutableImage& frame) {
  const int width = std::min(kTileSide, frame.size.width - x);
  const int height = std::min(kTileSide, frame.size.height - y);
  for (int row = 0; row < height; ++row) {
    switch (frame.format) {
      case PixelFormat::kRgbPlanar8:
        store_planar<std::uint8_t>(pixels, y + row, x, width, frame, row);
        break;
      case PixelFormat::kRgbPlanar16:
        store_planar<std::uint16_t>(pixels, y + row, x, width, frame, row);
        break;
      case PixelFormat::kRgb8:
        store_interleaved<std::uint8_t>(pixels, y + row, x, width, frame, row);
        break;
      case PixelFormat::kRgb16:
        store_interleaved<std::uint16_t>(pixels, y + row, x, width, frame, row);
        break;
      case PixelFormat::kXrgb8888:
        store_xrgb(pixels, y + row, x, width, frame, row);
        break;
    }
  }
}

}  // namespace

void store_tile(const TilePixels<std::uint8_t>& pixels, int x, int y, const MutableImage& frame) noexcept {
  store(pixels, x, y, frame);
}

void store_tile(const TilePixels<std::uint16_t>& pixels, int x, int y, const MutableImage& frame) noexcept {
  store(pixels, x, y, frame);
}

}  // namespace cupola
