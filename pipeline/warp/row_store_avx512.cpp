// Rows into the frame with AVX-512: 64 pixels a turn, whole cache lines past the caches.
// SPDX-License-Identifier: MIT
#include <immintrin.h>

#include <algorithm>

#include "pipeline/warp/row_store.h"

namespace cupola {
namespace {

constexpr int kTurn = 64;  // pixels

// Pixels until `out` is at a cache line, at most `count`; `step` bytes a pixel divide 64.
int pixels_to_line(const void* out, int step, int count) {
  const auto beyond = static_cast<int>(reinterpret_cast<std::uintptr_t>(out) % 64);
  return std::min(count, (64 - beyond) % 64 / step);
}

// Byte indices that pick two channels of 32 pixels (bytes b, g, r, x) out of two registers.
constexpr std::array<std::uint8_t, 64> pick(int first, int second) {
  std::array<std::uint8_t, 64> index{};
  for (int i = 0; i < 32; ++i) {
    index[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(4 * i + first);
    index[static_cast<std::size_t>(32 + i)] = static_cast<std::uint8_t>(4 * i + second);
  }
  return index;
}
alignas(64) constexpr auto kRedGreen = pick(2, 1);
alignas(64) constexpr auto kBlue = pick(0, 0);

struct Planes {
  __m512i red, green, blue;
};

// Of the first `count` of 64 pixels.
Planes split(const Xrgb* pixels, int count) {
  const auto load = [&](int first) {
    const int have = std::clamp(count - first, 0, 16);
    return _mm512_maskz_loadu_epi32(static_cast<__mmask16>((1U << have) - 1), pixels + first);
  };
  const __m512i red_green = _mm512_load_si512(kRedGreen.data());
  const __m512i blue = _mm512_load_si512(kBlue.data());
  const __m512i p0 = load(0);
  const __m512i p1 = load(16);
  const __m512i p2 = load(32);
  const __m512i p3 = load(48);
  const __m512i rg0 = _mm512_permutex2var_epi8(p0, red_green, p1);
  const __m512i rg1 = _mm512_permutex2var_epi8(p2, red_green, p3);
  const __m512i b0 = _mm512_permutex2var_epi8(p0, blue, p1);
  const __m512i b1 = _mm512_permutex2var_epi8(p2, blue, p3);
  return {_mm512_inserti64x4(rg0, _mm512_castsi512_si256(rg1), 1), _mm512_shuffle_i64x2(rg0, rg1, 0xee),
          _mm512_inserti64x4(b0, _mm512_castsi512_si256(b1), 1)};
}

void store_planar(const Xrgb* pixels, int count, const MutableImage& frame, int x, int y) {
  std::uint8_t* red = frame.samples<std::uint8_t>(0, y) + x;
  std::uint8_t* green = frame.samples<std::uint8_t>(1, y) + x;
  std::uint8_t* blue = frame.samples<std::uint8_t>(2, y) + x;
  const int before = pixels_to_line(red, 1, count);
  const bool together = pixels_to_line(green, 1, count) == before && pixels_to_line(blue, 1, count) == before;
  const auto part = [&](int at, int some) {
    const Planes planes = split(pixels + at, some);
    const __mmask64 mask = some == 64 ? ~__mmask64{0} : (__mmask64{1} << some) - 1;
    _mm512_mask_storeu_epi8(red + at, mask, planes.red);
    _mm512_mask_storeu_epi8(green + at, mask, planes.green);
    _mm512_mask_storeu_epi8(blue + at, mask, planes.blue);
  };
  int at = 0;
  if (together && before > 0) {
    part(0, before);
    at = before;
  }
  for (; at + kTurn <= count; at += kTurn) {
    if (!together) {
      part(at, kTurn);
      continue;
    }
    const Planes planes = split(pixels + at, kTurn);
    _mm512_stream_si512(reinterpret_cast<__m512i*>(red + at), planes.red);
    _mm512_stream_si512(reinterpret_cast<__m512i*>(green + at), planes.green);
    _mm512_stream_si512(reinterpret_cast<__m512i*>(blue + at), planes.blue);
  }
  if (at < count) part(at, count - at);
}

void store_xrgb(const Xrgb* pixels, int count, const MutableImage& frame, int x, int y) {
  Xrgb* out = frame.samples<Xrgb>(0, y) + x;
  const int before = pixels_to_line(out, 4, count);
  std::copy_n(pixels, before, out);
  int i = before;
  for (; i + 16 <= count; i += 16) {
    _mm512_stream_si512(reinterpret_cast<__m512i*>(out + i), _mm512_loadu_si512(pixels + i));
  }
  std::copy_n(pixels + i, count - i, out + i);
}

}  // namespace

void store_row_avx512(const Xrgb* pixels, int count, const MutableImage& frame, int x, int y) noexcept {
  if (frame.format == PixelFormat::kRgbPlanar8) {
    store_planar(pixels, count, frame, x, y);
  } else if (frame.format == PixelFormat::kXrgb8888) {
    store_xrgb(pixels, count, frame, x, y);
  } else {
    store_row_sse4(pixels, count, frame, x, y);
  }
}

}  // namespace cupola
