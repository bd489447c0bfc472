// Rows into the frame with SSE4.1: whole cache lines past the caches, what is before and after them through.
// SPDX-License-Identifier: MIT
#include <smmintrin.h>

#include "pipeline/warp/row_store.h"

namespace cupola {
namespace {

constexpr int kLinePixels = 64;  // whole lines in every format: 64, 192 or 256 bytes
constexpr int kStep = 16;        // pixels; whole registers in every format

using Put = void (*)(void* to, __m128i bytes);
CUPOLA_INLINE void put(void* to, __m128i bytes) {
  _mm_storeu_si128(static_cast<__m128i*>(to), bytes);
}
CUPOLA_INLINE void stream(void* to, __m128i bytes) {
  _mm_stream_si128(static_cast<__m128i*>(to), bytes);
}

CUPOLA_INLINE __m128i load(const Xrgb* four_pixels) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(four_pixels));
}

// Where pixels go: a plane a channel, or the first only and null.
struct Target {
  std::uint8_t* plane[3];
};

// Channel by channel, `kSteps` registers each, so that one line is full before the next is begun.
template <int kSteps, Put kPut>
CUPOLA_INLINE void put_planar(const Xrgb* pixels, const Target& to) {
  // Four pixels' bytes b, g, r, x: r r r r g g g g b b b b x x x x.
  const __m128i by_channel = _mm_setr_epi8(2, 6, 10, 14, 1, 5, 9, 13, 0, 4, 8, 12, 3, 7, 11, 15);
  __m128i channel[3][kSteps];
  for (int i = 0; i < kSteps; ++i, pixels += kStep) {
    const __m128i p0 = _mm_shuffle_epi8(load(pixels), by_channel);
    const __m128i p1 = _mm_shuffle_epi8(load(pixels + 4), by_channel);
    const __m128i p2 = _mm_shuffle_epi8(load(pixels + 8), by_channel);
    const __m128i p3 = _mm_shuffle_epi8(load(pixels + 12), by_channel);
    const __m128i red_green01 = _mm_unpacklo_epi32(p0, p1);
    const __m128i red_green23 = _mm_unpacklo_epi32(p2, p3);
    channel[0][i] = _mm_unpacklo_epi64(red_green01, red_green23);
    channel[1][i] = _mm_unpackhi_epi64(red_green01, red_green23);
    channel[2][i] = _mm_unpacklo_epi64(_mm_unpackhi_epi32(p0, p1), _mm_unpackhi_epi32(p2, p3));
  }
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < kSteps; ++i) kPut(to.plane[c] + i * 16, channel[c][i]);
  }
}

template <int kSteps, Put kPut>
CUPOLA_INLINE void put_rgb(const Xrgb* pixels, std::uint8_t* to) {
  // Four pixels' bytes b, g, r, x: 12 bytes r, g, b, then 4 zero ones.
  const __m128i packed = _mm_setr_epi8(2, 1, 0, 6, 5, 4, 10, 9, 8, 14, 13, 12, -1, -1, -1, -1);
  for (int i = 0; i < kSteps; ++i, pixels += kStep, to += 48) {
    const __m128i p0 = _mm_shuffle_epi8(load(pixels), packed);
    const __m128i p1 = _mm_shuffle_epi8(load(pixels + 4), packed);
    const __m128i p2 = _mm_shuffle_epi8(load(pixels + 8), packed);
    const __m128i p3 = _mm_shuffle_epi8(load(pixels + 12), packed);
    kPut(to, _mm_or_si128(p0, _mm_slli_si128(p1, 12)));
    kPut(to + 16, _mm_or_si128(_mm_srli_si128(p1, 4), _mm_slli_si128(p2, 8)));
    kPut(to + 32, _mm_or_si128(_mm_srli_si128(p2, 8), _mm_slli_si128(p3, 4)));
  }
}

template <int kSteps, Put kPut>
CUPOLA_INLINE void put_xrgb(const Xrgb* pixels, std::uint8_t* to) {
  for (int i = 0; i < kSteps * 4; ++i) kPut(to + i * 16, load(pixels + i * 4));
}

// 16 kSteps pixels at a time; returns how many pixels that were.
template <int kSteps, Put kPut>
int put_all(const Xrgb* pixels, int count, PixelFormat format, Target to) {
  constexpr int kPixels = kSteps * kStep;
  int done = 0;
  for (; done + kPixels <= count; done += kPixels, pixels += kPixels) {
    if (format == PixelFormat::kRgbPlanar8) {
      put_planar<kSteps, kPut>(pixels, to);
    } else if (format == PixelFormat::kRgb8) {
      put_rgb<kSteps, kPut>(pixels, to.plane[0]);
    } else {
      put_xrgb<kSteps, kPut>(pixels, to.plane[0]);
    }
    for (int plane = 0; plane < plane_count(format); ++plane) to.plane[plane] += kPixels * pixel_step(format);
  }
  return done;
}

Target target(const MutableImage& frame, int x, int y) {
  Target to{};
  for (int plane = 0; plane < plane_count(frame.format); ++plane) {
    to.plane[plane] = frame.samples<std::uint8_t>(plane, y) + x * pixel_step(frame.format);
  }
  return to;
}

// Pixels until `out` is at a cache line, or -1: never. `step` is 1, 3 or 4 bytes.
int pixels_to_line(const std::uint8_t* out, int step) {
  const auto missing = static_cast<int>(-reinterpret_cast<std::uintptr_t>(out) % 64);
  if (step == 3) return missing * 43 % 64;  // 3 * 43 is 1, mod 64
  return missing % step == 0 ? missing / step : -1;
}

void store_through(const Xrgb* pixels, int count, const MutableImage& frame, int x, int y) {
  const int done = put_all<1, put>(pixels, count, frame.format, target(frame, x, y));
  store_row_scalar(pixels + done, count - done, frame, x + done, y);
}

}  // namespace

void store_row_sse4(const Xrgb* pixels, int count, const MutableImage& frame, int x, int y) noexcept {
  if (sample_bytes(frame.format) != 1) return store_row_scalar(pixels, count, frame, x, y);
  const Target to = target(frame, x, y);
  const int step = pixel_step(frame.format);
  const int before = pixels_to_line(to.plane[0], step);
  bool aligned = before >= 0 && before <= count;
  for (int plane = 1; plane < plane_count(frame.format); ++plane) {
    aligned = aligned && pixels_to_line(to.plane[plane], step) == before;
  }
  if (!aligned) return store_through(pixels, count, frame, x, y);
  store_through(pixels, before, frame, x, y);
  const int lines = put_all<kLinePixels / kStep, stream>(pixels + before, count - before, frame.format,
                                                         target(frame, x + before, y));
  store_through(pixels + before + lines, count - before - lines, frame, x + before + lines, y);
}

void finish_rows_streamed() noexcept {
  _mm_sfence();
}

}  // namespace cupola
