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

void stream_planar(const Xrgb* pixels, int turns, std::uint8_t* red, std::uint8_t* green,
                   std::uint8_t* blue) {
  const __m512i red_green = _mm512_load_si512(kRedGreen.data());
  const __m512i blue_only = _mm512_load_si512(kBlue.data());
  for (int i = 0; i < turns; ++i, pixels += kTurn) {
    const __m512i p0 = _mm512_loadu_si512(pixels);
    const __m512i p1 = _mm512_loadu_si512(pixels + 16);
    const __m512i p2 = _mm512_loadu_si512(pixels + 32);
    const __m512i p3 = _mm512_loadu_si512(pixels + 48);
    const __m512i rg0 = _mm512_permutex2var_epi8(p0, red_green, p1);
    const __m512i rg1 = _mm512_permutex2var_epi8(p2, red_green, p3);
    const __m512i b0 = _mm512_permutex2var_epi8(p0, blue_only, p1);
    const __m512i b1 = _mm512_permutex2var_epi8(p2, blue_only, p3);
    const auto stream = [&](std::uint8_t* to, __m512i line) {
      _mm512_stream_si512(reinterpret_cast<__m512i*>(to + i * kTurn), line);
    };
    stream(red, _mm512_inserti64x4(rg0, _mm512_castsi512_si256(rg1), 1));
    stream(green, _mm512_shuffle_i64x2(rg0, rg1, 0xee));
    stream(blue, _mm512_inserti64x4(b0, _mm512_castsi512_si256(b1), 1));
  }
}

void store_planar(const Xrgb* pixels, int count, const MutableImage& frame, int x, int y) {
  std::array<std::uint8_t*, 3> to;
  for (int channel = 0; channel < 3; ++channel) to[channel] = frame.samples<std::uint8_t>(channel, y) + x;
  const int before = pixels_to_line(to[0], 1, count);
  if (pixels_to_line(to[1], 1, count) != before || pixels_to_line(to[2], 1, count) != before) {
    return store_row_sse4(pixels, count, frame, x, y);
  }
  const int turns = (count - before) / kTurn;
  const int streamed = before + turns * kTurn;
  store_row_sse4(pixels, before, frame, x, y);
  stream_planar(pixels + before, turns, to[0] + before, to[1] + before, to[2] + before);
  store_row_sse4(pixels + streamed, count - streamed, frame, x + streamed, y);
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
