// 16 bits to 8 with SSE4.1, four pixels at a time.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/dither_sse4.h"
#include "pipeline/warp/narrow_rows.h"
#include "pipeline/warp/sse4.h"

namespace cupola {
namespace {

// Two pixels of 4 samples, each narrowed by its threshold. n / 257 is n * 65281 / 2^24 for all n below 2^16.
CUPOLA_INLINE __m128i two_narrowed(const Rgb16* from, __m128i thresholds) {
  const __m128i sum = _mm_adds_epu16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from)), thresholds);
  return _mm_srli_epi16(_mm_mulhi_epu16(sum, _mm_set1_epi16(static_cast<short>(65281))), 8);
}

CUPOLA_INLINE void put(__m128i first, __m128i second, Xrgb* to) {
  const __m128i swapped = _mm_setr_epi8(2, 1, 0, -1, 6, 5, 4, -1, 10, 9, 8, -1, 14, 13, 12, -1);
  const __m128i pixels = _mm_shuffle_epi8(_mm_packus_epi16(first, second), swapped);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to),
                   _mm_or_si128(pixels, _mm_set1_epi32(static_cast<int>(kBlackXrgb))));
}

}  // namespace

void narrow_rounded_sse4(const Rgb16* from, int count, int x, int y, Xrgb* to) noexcept {
  const __m128i half = _mm_set1_epi16(128);
  int i = 0;
  for (; i + 4 <= count; i += 4) put(two_narrowed(from + i, half), two_narrowed(from + i + 2, half), to + i);
  narrow_rounded_scalar(from + i, count - i, x + i, y, to + i);
}

void narrow_dithered_sse4(const Rgb16* from, int count, int x, int y, Xrgb* to) noexcept {
  // A pixel's threshold to all its samples.
  const __m128i first_two = _mm_setr_epi8(0, 1, 0, 1, 0, 1, 0, 1, 4, 5, 4, 5, 4, 5, 4, 5);
  const __m128i last_two = _mm_add_epi8(first_two, _mm_set1_epi8(8));
  DitherOfFour dither(x, y);
  int i = 0;
  for (; i + 4 <= count; i += 4) {
    const __m128i threshold = _mm_mulhi_epu16(_mm_srli_epi32(dither.next(), 15), _mm_set1_epi16(257));
    put(two_narrowed(from + i, _mm_shuffle_epi8(threshold, first_two)),
        two_narrowed(from + i + 2, _mm_shuffle_epi8(threshold, last_two)), to + i);
  }
  narrow_dithered_scalar(from + i, count - i, x + i, y, to + i);
}

}  // namespace cupola
