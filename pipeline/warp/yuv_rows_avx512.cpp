// Luma and chroma on their way out with AVX-512: the scalar bits, whole cache lines past the caches.
// SPDX-License-Identifier: MIT
#include <immintrin.h>

#include <algorithm>

#include "pipeline/warp/yuv_rows.h"

namespace cupola {
namespace {

// Pixels until `to` is at a cache line, at most `count`; `step` bytes a pixel.
int pixels_to_line(const void* to, int step, int count) {
  const auto beyond = static_cast<int>(reinterpret_cast<std::uintptr_t>(to) % 64);
  return std::min(count, (64 - beyond) % 64 / step);
}

// kNoFine, which rounds to 1024 or with a carry lost to 0, becomes `black`.
__m512i rounded(__m512i fine, __m512i black) {
  const __mmask32 none = _mm512_cmpeq_epi16_mask(fine, _mm512_set1_epi16(-1));
  const __m512i half = _mm512_set1_epi16(1 << (kFineBits - 1));
  const __m512i value = _mm512_srli_epi16(_mm512_add_epi16(fine, half), kFineBits);
  return _mm512_mask_mov_epi16(value, none, black);
}

// 64 samples to bytes in order; packing works by 16-byte lanes.
__m512i packed(__m512i first, __m512i second) {
  const __m512i order = _mm512_setr_epi64(0, 2, 4, 6, 1, 3, 5, 7);
  return _mm512_permutexvar_epi64(order, _mm512_packus_epi16(first, second));
}

// The samples [first, first + 32) of `count`.
__m512i load(const std::uint16_t* from, int first, int count) {
  const int have = std::clamp(count - first, 0, 32);
  return _mm512_maskz_loadu_epi16(static_cast<__mmask32>((std::uint64_t{1} << have) - 1), from + first);
}

// Up to 64.
void store_some(const std::uint16_t* from, int count, __m512i black, std::uint8_t* to) {
  const __mmask64 mask = count == 64 ? ~__mmask64{0} : (__mmask64{1} << count) - 1;
  _mm512_mask_storeu_epi8(
      to, mask, packed(rounded(load(from, 0, count), black), rounded(load(from, 32, count), black)));
}

void store_samples(const std::uint16_t* from, int count, std::uint8_t black_value, std::uint8_t* to) {
  const __m512i black = _mm512_set1_epi16(black_value);
  const int before = pixels_to_line(to, 1, count);
  store_some(from, before, black, to);
  int at = before;
  for (; at + 64 <= count; at += 64) {
    const __m512i samples = packed(rounded(_mm512_loadu_si512(from + at), black),
                                   rounded(_mm512_loadu_si512(from + at + 32), black));
    _mm512_stream_si512(reinterpret_cast<__m512i*>(to + at), samples);
  }
  store_some(from + at, count - at, black, to + at);
}

void store_luma(const Luma* from, int count, std::uint8_t black, std::uint8_t* to) noexcept {
  store_samples(from, count, black, to);
}

void store_chroma(const Chroma* from, int count, std::uint8_t* to) noexcept {
  store_samples(reinterpret_cast<const std::uint16_t*>(from), 2 * count, 128, to);
}

// A channel's coefficients, for multiplying pairs of 16 bits.
struct Channel {
  explicit Channel(const YuvToRgb::Channel& of)
      : luma(_mm512_set1_epi32(of.y)),
        chroma(_mm512_set1_epi32(of.v * 65536 + static_cast<std::uint16_t>(of.u))),
        start(_mm512_set1_epi32(of.start)) {}
  __m512i luma, chroma, start;
};

class Converter {
 public:
  explicit Converter(const YuvToRgb& matrix) : red_(matrix.red), green_(matrix.green), blue_(matrix.blue) {}

  // 16 pixels; of `y` the upper 16 bits of each lane are 0.
  __m512i operator()(__m512i y, __m512i uv) const {
    const __mmask16 grey = _mm512_cmpeq_epi32_mask(uv, _mm512_set1_epi32(-1));
    const __m512i chroma = _mm512_mask_mov_epi32(uv, grey, _mm512_set1_epi16(128 << kFineBits));
    const __m512i pixels =
        _mm512_ternarylogic_epi32(_mm512_or_si512(_mm512_slli_epi32(sample(red_, y, chroma), 16),
                                                  _mm512_slli_epi32(sample(green_, y, chroma), 8)),
                                  sample(blue_, y, chroma), black_, 0xfe);
    const __mmask16 outside = _mm512_cmpeq_epi32_mask(y, _mm512_set1_epi32(kNoFine));
    return _mm512_mask_mov_epi32(pixels, outside, black_);
  }

 private:
  static __m512i sample(const Channel& channel, __m512i y, __m512i chroma) {
    const __m512i sum = _mm512_add_epi32(_mm512_add_epi32(_mm512_madd_epi16(y, channel.luma), channel.start),
                                         _mm512_madd_epi16(chroma, channel.chroma));
    const __m512i value = _mm512_srai_epi32(sum, YuvToRgb::kShift);
    return _mm512_min_epi32(_mm512_max_epi32(value, _mm512_setzero_si512()), _mm512_set1_epi32(255));
  }

  Channel red_, green_, blue_;
  __m512i black_ = _mm512_set1_epi32(static_cast<int>(kBlackXrgb));
};

// Up to 16.
void convert_some(const Converter& converter, const Luma* luma, const Chroma* chroma, int count, Xrgb* to) {
  const auto mask = static_cast<__mmask16>((1U << count) - 1);
  const __m512i y = _mm512_cvtepu16_epi32(_mm256_maskz_loadu_epi16(mask, luma));
  _mm512_mask_storeu_epi32(to, mask, converter(y, _mm512_maskz_loadu_epi32(mask, chroma)));
}

void convert(const Luma* luma, const Chroma* chroma, int count, const YuvToRgb& matrix, Xrgb* to) noexcept {
  const Converter converter(matrix);
  const int before = pixels_to_line(to, 4, count);
  convert_some(converter, luma, chroma, before, to);
  int at = before;
  for (; at + 16 <= count; at += 16) {
    const __m256i y = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(luma + at));
    _mm512_stream_si512(reinterpret_cast<__m512i*>(to + at),
                        converter(_mm512_cvtepu16_epi32(y), _mm512_loadu_si512(chroma + at)));
  }
  convert_some(converter, luma + at, chroma + at, count - at, to + at);
}

}  // namespace

const YuvRows kYuvRowsAvx512{store_luma, store_chroma, convert, convert_dithered_sse4};

}  // namespace cupola
