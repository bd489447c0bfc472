// Windows of 8 x 8 texels into registers, one a channel, with AVX-512: from planes of one channel, and out of
// texels that lie between others. No byte is read outside the texels' own.
// SPDX-License-Identifier: MIT
#pragma once

#include <immintrin.h>

#include "pipeline/warp/light.h"
#include "pipeline/warp/tile_kernel.h"

#define CUPOLA_INLINE_LAMBDA __attribute__((always_inline))

namespace cupola {

template <int kCount>
struct Channels {
  __m512i of[kCount];
  __m512i& operator[](int channel) { return of[channel]; }
  const __m512i& operator[](int channel) const { return of[channel]; }
};

// Loads windows of texels kStep bytes apart. An object holds masks for the parts of a register; as plain
// constants compilers would make them anew for every block.
template <int kCount, int kStep>
class WindowLoad;

// Rows are merged by broadcasting loads under a mask: those need no shuffle port, which the permutations keep
// busy.
template <int kCount>
class WindowLoad<kCount, 1> {
 public:
  WindowLoad() {
    for (int row = 0; row < kWindowSide; ++row) {
      row_[row] = static_cast<__mmask8>(1 << row);
      asm("" : "+Yk"(row_[row]));
    }
  }

  // The first kRows rows.
  template <int kRows>
  CUPOLA_INLINE Channels<kCount> rows(const ViewTexels& view, const std::uint8_t* texels) const {
    Channels<kCount> channels;
    channels[0] = plane<kRows>(texels, view.stride);
    for (int i = 1; i < kCount; ++i) channels[i] = plane<kRows>(texels + view.channel[i], view.stride);
    return channels;
  }

 private:
  template <int kRows>
  CUPOLA_INLINE __m512i plane(const std::uint8_t* texels, std::ptrdiff_t stride) const {
    const auto row = [&](int y) {
      return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(texels + y * stride));
    };
    __m512i window = _mm512_castsi128_si512(row(0));
#pragma GCC unroll 8
    for (int y = 1; y < kRows; ++y) window = _mm512_mask_broadcastq_epi64(window, row_[y], row(y));
    return window;
  }

  __mmask8 row_[kWindowSide];
};

// Texels of two bytes: even rows in one register, odd ones in another, and packing 16 bits to 8 puts them in
// order. One channel may be either byte of the two; two channels are both.
template <int kCount>
class WindowLoad<kCount, 2> {
 public:
  WindowLoad() {
    for (int lane = 0; lane < 4; ++lane) {
      lane_[lane] = static_cast<__mmask8>(3 << 2 * lane);
      asm("" : "+Yk"(lane_[lane]));
    }
  }

  template <int kRows>
  CUPOLA_INLINE Channels<kCount> rows(const ViewTexels& view, const std::uint8_t* texels) const {
    __m512i even = _mm512_castsi128_si512(row(texels, 0, view.stride));
    __m512i odd = _mm512_castsi128_si512(row(texels, 1, view.stride));
#pragma GCC unroll 4
    for (int lane = 1; lane < kRows / 2; ++lane) {
      even = _mm512_mask_broadcast_i64x2(even, lane_[lane], row(texels, 2 * lane, view.stride));
      odd = _mm512_mask_broadcast_i64x2(odd, lane_[lane], row(texels, 2 * lane + 1, view.stride));
    }
    const __m512i byte = _mm512_set1_epi16(0xff);
    if constexpr (kCount == 1) {
      const __m512i shift = _mm512_set1_epi16(static_cast<short>(8 * view.channel[0]));
      return {{_mm512_packus_epi16(_mm512_and_si512(_mm512_srlv_epi16(even, shift), byte),
                                   _mm512_and_si512(_mm512_srlv_epi16(odd, shift), byte))}};
    } else {
      return {{_mm512_packus_epi16(_mm512_and_si512(even, byte), _mm512_and_si512(odd, byte)),
               _mm512_packus_epi16(_mm512_srli_epi16(even, 8), _mm512_srli_epi16(odd, 8))}};
    }
  }

 private:
  CUPOLA_INLINE static __m128i row(const std::uint8_t* texels, int y, std::ptrdiff_t stride) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(texels + y * stride));
  }
  __mmask8 lane_[4];
};

// Two channels, every other of four bytes: two packings, after which fours of texels of rows 0 2 4 6 (left
// halves), 0 2 4 6 (right halves), 1 3 5 7 and 1 3 5 7 follow one another.
template <>
class WindowLoad<2, 4> {
 public:
  template <int kRows>
  CUPOLA_INLINE Channels<2> rows(const ViewTexels& view, const std::uint8_t* texels) const {
    const __m512i byte = _mm512_set1_epi16(0xff);
    const __m512i shift = _mm512_set1_epi16(static_cast<short>(8 * (view.channel[0] & 1)));
    const auto row = [&](int y) {
      return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(texels + y * view.stride));
    };
    const auto pair = [&](int y) CUPOLA_INLINE_LAMBDA {
      const __m512i both = _mm512_inserti64x4(_mm512_castsi256_si512(row(y)), row(y + 1), 1);
      return _mm512_and_si512(_mm512_srlv_epi16(both, shift), byte);
    };
    const __m512i none = _mm512_setzero_si512();
    const __m512i upper = _mm512_packus_epi16(pair(0), kRows > 2 ? pair(2) : none);
    const __m512i lower = kRows > 4 ? _mm512_packus_epi16(pair(4), kRows > 6 ? pair(6) : none) : none;
    const __m512i order = _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
    return {{_mm512_permutexvar_epi32(
                 order, _mm512_packus_epi16(_mm512_and_si512(upper, byte), _mm512_and_si512(lower, byte))),
             _mm512_permutexvar_epi32(
                 order, _mm512_packus_epi16(_mm512_srli_epi16(upper, 8), _mm512_srli_epi16(lower, 8)))}};
  }
};

// Three channels out of texels of three or four bytes: two rows in a register, four rows a permutation.
template <int kStep>
class PackedWindowLoad {
 public:
  template <int kRows>
  CUPOLA_INLINE Channels<3> rows(const ViewTexels& view, const std::uint8_t* texels) const {
    const auto row = [&](int y) { return _mm256_maskz_loadu_epi8(kRowBytes, texels + y * view.stride); };
    const auto two = [&](int y) CUPOLA_INLINE_LAMBDA {
      return _mm512_inserti64x4(_mm512_castsi256_si512(row(y)), row(y + 1), 1);
    };
    const __m512i none = _mm512_setzero_si512();
    const __m512i first = two(0);
    const __m512i second = kRows > 2 ? two(2) : none;
    const __m512i third = kRows > 4 ? two(4) : none;
    const __m512i fourth = kRows > 6 ? two(6) : none;
    Channels<3> channels;
    for (int i = 0; i < 3; ++i) {
      const __m512i at = _mm512_add_epi8(_mm512_load_si512(kPlaces.data()),
                                         _mm512_set1_epi8(static_cast<char>(view.channel[i])));
      channels[i] = _mm512_permutex2var_epi8(first, at, second);
      if constexpr (kRows > 4) {
        const __m256i lower = _mm512_castsi512_si256(_mm512_permutex2var_epi8(third, at, fourth));
        channels[i] = _mm512_inserti64x4(channels[i], lower, 1);
      }
    }
    return channels;
  }

 private:
  static constexpr __mmask32 kRowBytes = kStep == 4 ? 0xffffffff : 0xffffff;
  // Of two registers' 128 bytes the first of each texel, row by row; the second half is of no use.
  alignas(64) static constexpr std::array<std::uint8_t, 64> kPlaces = [] {
    std::array<std::uint8_t, 64> places{};
    for (int i = 0; i < 32; ++i)
      places[static_cast<std::size_t>(i)] =
          static_cast<std::uint8_t>(i / kWindowSide * 32 + i % kWindowSide * kStep);
    return places;
  }();
};
template <>
class WindowLoad<3, 3> : public PackedWindowLoad<3> {};
template <>
class WindowLoad<3, 4> : public PackedWindowLoad<4> {};

// Low and high bytes of three planes of 16 bits.
template <>
class WindowLoad<6, 2> {
 public:
  template <int kRows>
  CUPOLA_INLINE Channels<6> rows(const ViewTexels& view, const std::uint8_t* texels) const {
    Channels<6> channels;
    for (int plane = 0; plane < 3; ++plane) {
      const std::uint8_t* first = plane == 0 ? texels : texels + view.channel[plane];
      const Channels<2> bytes = plane_.rows<kRows>(view, first);
      channels[2 * plane] = bytes[0];
      channels[2 * plane + 1] = bytes[1];
    }
    return channels;
  }

 private:
  WindowLoad<2, 2> plane_;
};

// Low and high bytes of the light of three planes of sRGB bytes: all 64 texels are looked up at once, in each
// half of a table of 256 bytes.
template <>
class WindowLoad<6, 1> {
 public:
  template <int kRows>
  CUPOLA_INLINE Channels<6> rows(const ViewTexels& view, const std::uint8_t* texels) const {
    const Channels<3> srgb = plane_.rows<kRows>(view, texels);
    Channels<6> channels;
    for (int plane = 0; plane < 3; ++plane) {
      const __mmask64 bright = _mm512_movepi8_mask(srgb[plane]);
      look_up(kLightOfSrgb8.low.data(), srgb[plane], bright, channels[2 * plane]);
      look_up(kLightOfSrgb8.high.data(), srgb[plane], bright, channels[2 * plane + 1]);
    }
    return channels;
  }

 private:
  CUPOLA_INLINE static void look_up(const std::uint8_t* table, const __m512i& texels, __mmask64 bright,
                                    __m512i& light) {
    const auto* parts = reinterpret_cast<const __m512i*>(table);  // aligned, of 64 bytes
    const __m512i dark = _mm512_permutex2var_epi8(parts[0], texels, parts[1]);
    light = _mm512_mask_mov_epi8(dark, bright, _mm512_permutex2var_epi8(parts[2], texels, parts[3]));
  }
  WindowLoad<3, 1> plane_;
};

// The same window of several images.
template <int kImages, int kCount>
struct Texels {
  Channels<kCount> of[kImages];
};

template <int kImages, int kRows, int kCount, int kStep, class Pixel>
CUPOLA_INLINE Texels<kImages, kCount> load_rows(const TileImage<Pixel>* images, const Window& window,
                                                const WindowLoad<kCount, kStep>& load) {
  Texels<kImages, kCount> texels;
  for (int i = 0; i < kImages; ++i) {
    const ViewTexels& view = images[i].views[window.view];
    texels.of[i] = load.template rows<kRows>(view, view.window(window.x, window.y));
  }
  return texels;
}

template <int kImages, int kCount, int kStep, class Pixel>
CUPOLA_INLINE Texels<kImages, kCount> load_windows(const TileImage<Pixel>* images, const Window& window,
                                                   const WindowLoad<kCount, kStep>& load) {
  switch ((window.used + 1) / 2) {
    case 0:
    case 1:
      return load_rows<kImages, 2>(images, window, load);
    case 2:
      return load_rows<kImages, 4>(images, window, load);
    case 3:
      return load_rows<kImages, 6>(images, window, load);
    default:
      return load_rows<kImages, 8>(images, window, load);
  }
}

}  // namespace cupola
