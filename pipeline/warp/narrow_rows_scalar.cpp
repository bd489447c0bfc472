// The definition of how 16 bits become 8.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/light.h"
#include "pipeline/warp/narrow_rows.h"

namespace cupola {
namespace {

Xrgb xrgb(unsigned r, unsigned g, unsigned b) {
  return kBlackXrgb | r << 16 | g << 8 | b;
}

Xrgb narrowed(const Rgb16& pixel, unsigned threshold) {
  return xrgb(cupola::narrowed(pixel.r, threshold), cupola::narrowed(pixel.g, threshold),
              cupola::narrowed(pixel.b, threshold));
}

}  // namespace

void narrow_rounded_scalar(const Rgb16* from, int count, int, int, Xrgb* to) noexcept {
  for (int i = 0; i < count; ++i) to[i] = narrowed(from[i], 128);
}

void narrow_dithered_scalar(const Rgb16* from, int count, int x, int y, Xrgb* to) noexcept {
  for (int i = 0; i < count; ++i) to[i] = narrowed(from[i], dither_threshold(x + i, y));
}

void narrow_light(const Rgb16* from, int count, int, int, Xrgb* to) noexcept {
  const auto& srgb = light_tables().srgb8_of_light;
  for (int i = 0; i < count; ++i) to[i] = xrgb(srgb[from[i].r], srgb[from[i].g], srgb[from[i].b]);
}

void narrow_light_dithered(const Rgb16* from, int count, int x, int y, Xrgb* to) noexcept {
  const auto& srgb = light_tables().srgb16_of_light;
  for (int i = 0; i < count; ++i) {
    to[i] = narrowed({srgb[from[i].r], srgb[from[i].g], srgb[from[i].b], 0}, dither_threshold(x + i, y));
  }
}

}  // namespace cupola
