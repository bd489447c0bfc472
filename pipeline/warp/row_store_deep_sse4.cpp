// Rows of 16 bits a sample into frames of as many, with SSE4.1.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/row_store_wide.h"
#include "pipeline/warp/sse4.h"

namespace cupola {
namespace {

CUPOLA_INLINE __m128i load(const Rgb16* two_pixels) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(two_pixels));
}

CUPOLA_INLINE void put(std::uint16_t* to, __m128i samples) {
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), samples);
}

// Four pixels: r r r r g g g g and b b b b, then four of no use.
struct Four {
  __m128i red_green, blue;
};
CUPOLA_INLINE Four four_by_channel(const Rgb16* pixels) {
  const __m128i first = load(pixels);
  const __m128i second = load(pixels + 2);
  const __m128i even = _mm_unpacklo_epi16(first, second);
  const __m128i odd = _mm_unpackhi_epi16(first, second);
  return {_mm_unpacklo_epi16(even, odd), _mm_unpackhi_epi16(even, odd)};
}

int store_planar(const Rgb16* pixels, int count, const MutableImage& frame, int x, int y) {
  std::uint16_t* red = frame.samples<std::uint16_t>(0, y) + x;
  std::uint16_t* green = frame.samples<std::uint16_t>(1, y) + x;
  std::uint16_t* blue = frame.samples<std::uint16_t>(2, y) + x;
  int i = 0;
  for (; i + 8 <= count; i += 8) {
    const Four left = four_by_channel(pixels + i);
    const Four right = four_by_channel(pixels + i + 4);
    put(red + i, _mm_unpacklo_epi64(left.red_green, right.red_green));
    put(green + i, _mm_unpackhi_epi64(left.red_green, right.red_green));
    put(blue + i, _mm_unpacklo_epi64(left.blue, right.blue));
  }
  return i;
}

// A register of two pixels ends in two samples of no use, which the next two pixels overwrite.
int store_interleaved(const Rgb16* pixels, int count, const MutableImage& frame, int x, int y) {
  std::uint16_t* to = frame.samples<std::uint16_t>(0, y) + x * 3;
  const __m128i packed = _mm_setr_epi8(0, 1, 2, 3, 4, 5, 8, 9, 10, 11, 12, 13, -1, -1, -1, -1);
  int i = 0;
  for (; i + 3 <= count; i += 2) put(to + 3 * i, _mm_shuffle_epi8(load(pixels + i), packed));
  return i;
}

}  // namespace

void store_row_deep_sse4(const Rgb16* pixels, int count, const MutableImage& frame, int x, int y) noexcept {
  const int done = frame.format == PixelFormat::kRgb16 ? store_interleaved(pixels, count, frame, x, y)
                                                       : store_planar(pixels, count, frame, x, y);
  store_row_deep(pixels + done, count - done, frame, x + done, y);
}

}  // namespace cupola
