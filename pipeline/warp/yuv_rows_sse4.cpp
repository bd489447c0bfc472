// Luma and chroma on their way out with SSE4.1: the scalar bits, four or eight pixels at a time.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/dither_sse4.h"
#include "pipeline/warp/sse4.h"
#include "pipeline/warp/yuv_rows.h"

namespace cupola {
namespace {

CUPOLA_INLINE __m128i load(const void* from) {
  return _mm_loadu_si128(static_cast<const __m128i*>(from));
}

// Eight samples; kNoFine becomes `black`.
CUPOLA_INLINE __m128i rounded(__m128i fine, __m128i black) {
  const __m128i none = _mm_cmpeq_epi16(fine, _mm_set1_epi16(-1));
  const __m128i half = _mm_set1_epi16(1 << (kFineBits - 1));
  return _mm_blendv_epi8(_mm_srli_epi16(_mm_add_epi16(fine, half), kFineBits), black, none);
}

// As many of `count` samples as registers take; their number.
int store_samples(const std::uint16_t* from, int count, std::uint8_t black_value, std::uint8_t* to) {
  const __m128i black = _mm_set1_epi16(black_value);
  int i = 0;
  for (; i + 16 <= count; i += 16) {
    const __m128i samples =
        _mm_packus_epi16(rounded(load(from + i), black), rounded(load(from + i + 8), black));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to + i), samples);
  }
  return i;
}

void store_luma(const Luma* from, int count, std::uint8_t black, std::uint8_t* to) noexcept {
  const int done = store_samples(from, count, black, to);
  kYuvRowsScalar.luma(from + done, count - done, black, to + done);
}

void store_chroma(const Chroma* from, int count, std::uint8_t* to) noexcept {
  const int done = store_samples(reinterpret_cast<const std::uint16_t*>(from), 2 * count, 128, to) / 2;
  kYuvRowsScalar.chroma(from + done, count - done, to + 2 * done);
}

// A channel's coefficients, for multiplying pairs of 16 bits.
struct Channel {
  explicit Channel(const YuvToRgb::Channel& of)
      : luma(_mm_set1_epi32(of.y)),
        chroma(_mm_set1_epi32(of.v * 65536 + static_cast<std::uint16_t>(of.u))),
        start(_mm_set1_epi32(of.start)) {}

  CUPOLA_INLINE __m128i sample(__m128i y, __m128i uv, __m128i more) const {
    const __m128i sum = _mm_add_epi32(_mm_add_epi32(_mm_madd_epi16(y, luma), _mm_add_epi32(start, more)),
                                      _mm_madd_epi16(uv, chroma));
    const __m128i value = _mm_srai_epi32(sum, YuvToRgb::kShift);
    return _mm_min_epi32(_mm_max_epi32(value, _mm_setzero_si128()), _mm_set1_epi32(255));
  }

  __m128i luma, chroma, start;
};

class Converter {
 public:
  explicit Converter(const YuvToRgb& matrix) : red_(matrix.red), green_(matrix.green), blue_(matrix.blue) {}

  // Four pixels; `more` than half a step is added before rounding down.
  CUPOLA_INLINE void operator()(const Luma* luma, const Chroma* chroma, __m128i more, Xrgb* to) const {
    const __m128i y = _mm_cvtepu16_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(luma)));
    const __m128i both = load(chroma);
    const __m128i uv = _mm_blendv_epi8(both, grey_, _mm_cmpeq_epi32(both, _mm_set1_epi32(-1)));
    const __m128i red_green = _mm_or_si128(_mm_slli_epi32(red_.sample(y, uv, more), 16),
                                           _mm_slli_epi32(green_.sample(y, uv, more), 8));
    const __m128i pixels = _mm_or_si128(_mm_or_si128(red_green, blue_.sample(y, uv, more)), black_);
    const __m128i outside = _mm_cmpeq_epi32(y, _mm_set1_epi32(kNoFine));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm_blendv_epi8(pixels, black_, outside));
  }

 private:
  Channel red_, green_, blue_;
  __m128i black_ = _mm_set1_epi32(static_cast<int>(kBlackXrgb));
  __m128i grey_ = _mm_set1_epi16(128 << kFineBits);
};

void convert(const Luma* luma, const Chroma* chroma, int count, const YuvToRgb& matrix, Xrgb* to) noexcept {
  const Converter converter(matrix);
  int i = 0;
  for (; i + 4 <= count; i += 4) converter(luma + i, chroma + i, _mm_setzero_si128(), to + i);
  kYuvRowsScalar.xrgb(luma + i, chroma + i, count - i, matrix, to + i);
}

}  // namespace

void convert_dithered_sse4(const Luma* luma, const Chroma* chroma, int count, const YuvToRgb& matrix, int x,
                           int y, Xrgb* to) noexcept {
  const Converter converter(matrix);
  const __m128i less = _mm_set1_epi32(kLeastThreshold - (1 << (YuvToRgb::kShift - 1)));
  DitherOfFour dither(x, y);
  int i = 0;
  for (; i + 4 <= count; i += 4) {
    // Fifteen times 15 bits, as yuv_threshold().
    const __m128i steps = _mm_srli_epi32(dither.next(), 16);
    const __m128i threshold = _mm_sub_epi32(_mm_slli_epi32(steps, 4), steps);
    converter(luma + i, chroma + i, _mm_add_epi32(threshold, less), to + i);
  }
  kYuvRowsScalar.xrgb_dithered(luma + i, chroma + i, count - i, matrix, x + i, y, to + i);
}

const YuvRows kYuvRowsSse4{store_luma, store_chroma, convert, convert_dithered_sse4};

}  // namespace cupola
