// Writes single finished pixels into frames of any format; for the methods that go pixel by pixel.
// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "pipeline/frame/image.h"

namespace cupola {

// One channel's value in [0, most] rounded to nearest.
inline unsigned round_sample(double value, double most) {
  return static_cast<unsigned>(std::floor(std::fmin(std::fmax(value, 0.0), most) + 0.5));
}

// `r`, `g`, `b` in units of faces of `face_bytes` bytes a sample, whole numbers.
inline void store_pixel(const MutableImage& frame, int x, int y, int face_bytes, unsigned r, unsigned g,
                        unsigned b) {
  const bool wide_frame = sample_bytes(frame.format) == 2;
  if (face_bytes == 2 && !wide_frame) {
    const auto narrow = [](unsigned v) { return (v * 255U + 32767U) / 65535U; };
    r = narrow(r);
    g = narrow(g);
    b = narrow(b);
  } else if (face_bytes == 1 && wide_frame) {
    r *= 257U;
    g *= 257U;
    b *= 257U;
  }
  const unsigned rgb[3] = {r, g, b};
  for (int channel = 0; channel < 3; ++channel) {
    const unsigned value = rgb[channel];
    switch (frame.format) {
      case PixelFormat::kRgbPlanar8:
        frame.samples<std::uint8_t>(channel, y)[x] = static_cast<std::uint8_t>(value);
        break;
      case PixelFormat::kRgbPlanar16:
        frame.samples<std::uint16_t>(channel, y)[x] = static_cast<std::uint16_t>(value);
        break;
      case PixelFormat::kRgb8:
        frame.samples<std::uint8_t>(0, y)[x * 3 + channel] = static_cast<std::uint8_t>(value);
        break;
      case PixelFormat::kRgb16:
        frame.samples<std::uint16_t>(0, y)[x * 3 + channel] = static_cast<std::uint16_t>(value);
        break;
      case PixelFormat::kXrgb8888:
        frame.samples<std::uint32_t>(0, y)[x] = 0xff000000U | r << 16 | g << 8 | b;
        break;
    }
  }
}

}  // namespace cupola
