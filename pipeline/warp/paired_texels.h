// Two rows of a window of 8 x 8 texels into registers of 16 bytes, one a channel of bytes, for the kernels
// that shuffle those: from planes of bytes, of 16 bits, of sRGB to be made linear, out of packed YUV and RGB.
// No byte is read outside the texels' own.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/warp/light.h"
#include "pipeline/warp/sse4.h"
#include "pipeline/warp/tile_kernel.h"

namespace cupola {

template <int kCount>
struct TwoRows {
  __m128i of[kCount];
};

// Texels kStep bytes apart for pixels of a kind: kSources pictures in memory, each of which gives kOfSource
// channels of bytes; 16 bits are the channels of the low and of the high bytes. `Lanes` is of the including
// file alone, as in tile_kernel_pairs.h.
template <class Lanes, class Pixel, int kStep>
struct PairedTexels;

// Of 8 texels of four bytes: all first bytes and all second ones; all third and all fourth ones.
struct BytesOfFour {
  __m128i first_two, last_two;
};

template <class Lanes>
struct PairedRows {
  CUPOLA_INLINE static __m128i load(const std::uint8_t* bytes) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
  }
  CUPOLA_INLINE static __m128i two_rows_of_bytes(const std::uint8_t* row, std::ptrdiff_t stride) {
    const __m128i upper = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(row));
    return _mm_castps_si128(
        _mm_loadh_pi(_mm_castsi128_ps(upper), reinterpret_cast<const __m64*>(row + stride)));
  }
  CUPOLA_INLINE static __m128i low(__m128i words) { return _mm_and_si128(words, _mm_set1_epi16(0xff)); }
  CUPOLA_INLINE static __m128i high(__m128i words) { return _mm_srli_epi16(words, 8); }
  // Low and high bytes of two rows of 8 words.
  CUPOLA_INLINE static TwoRows<2> apart(__m128i upper, __m128i lower) {
    return {{_mm_packus_epi16(low(upper), low(lower)), _mm_packus_epi16(high(upper), high(lower))}};
  }
  CUPOLA_INLINE static BytesOfFour bytes_of_four(const std::uint8_t* row) {
    const __m128i by_byte = _mm_setr_epi8(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
    const __m128i left = _mm_shuffle_epi8(load(row), by_byte);
    const __m128i right = _mm_shuffle_epi8(load(row + 16), by_byte);
    return {_mm_unpacklo_epi32(left, right), _mm_unpackhi_epi32(left, right)};
  }
};

// A plane of bytes a channel.
template <class Lanes, int kPlanes>
struct PlanesOfBytes {
  static constexpr int kSources = kPlanes;
  static constexpr int kOfSource = 1;
  CUPOLA_INLINE static const std::uint8_t* first(const ViewTexels& view, int source, int x, int y) {
    return view.window(source, x, y);
  }
  CUPOLA_INLINE static TwoRows<1> two_rows(const ViewTexels&, const std::uint8_t* row,
                                           std::ptrdiff_t stride) {
    return {{PairedRows<Lanes>::two_rows_of_bytes(row, stride)}};
  }
};
template <class Lanes>
struct PairedTexels<Lanes, Xrgb, 1> : PlanesOfBytes<Lanes, 3> {};
template <class Lanes>
struct PairedTexels<Lanes, Luma, 1> : PlanesOfBytes<Lanes, 1> {};
template <class Lanes>
struct PairedTexels<Lanes, Chroma, 1> : PlanesOfBytes<Lanes, 2> {};

// Planes of 16 bits.
template <class Lanes>
struct PairedTexels<Lanes, Rgb16, 2> {
  static constexpr int kSources = 3;
  static constexpr int kOfSource = 2;
  CUPOLA_INLINE static const std::uint8_t* first(const ViewTexels& view, int source, int x, int y) {
    return view.window(source, x, y);
  }
  CUPOLA_INLINE static TwoRows<2> two_rows(const ViewTexels&, const std::uint8_t* row,
                                           std::ptrdiff_t stride) {
    using Rows = PairedRows<Lanes>;
    return Rows::apart(Rows::load(row), Rows::load(row + stride));
  }
};

// Planes of sRGB bytes, made linear 16 bits by looking every texel up.
template <class Lanes>
struct PairedTexels<Lanes, Rgb16, 1> {
  static constexpr int kSources = 3;
  static constexpr int kOfSource = 2;
  CUPOLA_INLINE static const std::uint8_t* first(const ViewTexels& view, int source, int x, int y) {
    return view.window(source, x, y);
  }
  CUPOLA_INLINE static TwoRows<2> two_rows(const ViewTexels&, const std::uint8_t* row,
                                           std::ptrdiff_t stride) {
    return PairedRows<Lanes>::apart(linear(row), linear(row + stride));
  }

 private:
  CUPOLA_INLINE static __m128i linear(const std::uint8_t* t) {
    const std::uint16_t* of = kLightOfSrgb8.words.data();
    const auto two = [of](std::uint8_t a, std::uint8_t b) { return of[a] | of[b] << 16; };
    return _mm_setr_epi32(two(t[0], t[1]), two(t[2], t[3]), two(t[4], t[5]), two(t[6], t[7]));
  }
};

// Planes of 16 bits of sRGB, made linear.
inline constexpr int kLightOf16 = 16;
template <class Lanes>
struct PairedTexels<Lanes, Rgb16, kLightOf16> {
  static constexpr int kSources = 3;
  static constexpr int kOfSource = 2;
  CUPOLA_INLINE static const std::uint8_t* first(const ViewTexels& view, int source, int x, int y) {
    return view.window(source, x, y);
  }
  CUPOLA_INLINE static TwoRows<2> two_rows(const ViewTexels&, const std::uint8_t* row,
                                           std::ptrdiff_t stride) {
    return PairedRows<Lanes>::apart(linear(row), linear(row + stride));
  }

 private:
  CUPOLA_INLINE static __m128i linear(const std::uint8_t* row) {
    const std::uint16_t* of = light_tables().light_of_srgb16.data();
    const auto* t = reinterpret_cast<const std::uint16_t*>(row);
    const auto two = [of](std::uint16_t a, std::uint16_t b) { return of[a] | of[b] << 16; };
    return _mm_setr_epi32(two(t[0], t[1]), two(t[2], t[3]), two(t[4], t[5]), two(t[6], t[7]));
  }
};

// All of three bytes, in the order that view.channel says.
template <class Lanes>
struct PairedTexels<Lanes, Xrgb, 3> {
  static constexpr int kSources = 1;
  static constexpr int kOfSource = 3;
  CUPOLA_INLINE static const std::uint8_t* first(const ViewTexels& view, int, int x, int y) {
    return view.window(x, y);
  }
  CUPOLA_INLINE static TwoRows<3> two_rows(const ViewTexels& view, const std::uint8_t* row,
                                           std::ptrdiff_t stride) {
    using Rows = PairedRows<Lanes>;
    const __m128i upper = Rows::load(row);
    const __m128i lower = Rows::load(row + stride);
    const __m128i ends = Rows::two_rows_of_bytes(row + 16, stride);  // bytes 16 to 23 of either
    TwoRows<3> rows;
    for (int i = 0; i < 3; ++i) {
      const Picks& picks = kPicks[static_cast<std::size_t>(view.channel[i])];
      const auto pick = [](__m128i from, const std::array<std::uint8_t, 16>& bytes) {
        return _mm_shuffle_epi8(from, _mm_load_si128(reinterpret_cast<const __m128i*>(bytes.data())));
      };
      rows.of[i] = _mm_or_si128(_mm_or_si128(pick(upper, picks.upper), pick(lower, picks.lower)),
                                pick(ends, picks.ends));
    }
    return rows;
  }

 private:
  // Where a channel's 16 bytes are: 0x80 where they come from another register.
  struct Picks {
    alignas(16) std::array<std::uint8_t, 16> upper{}, lower{}, ends{};
  };
  static constexpr std::array<Picks, 3> kPicks = [] {
    std::array<Picks, 3> picks{};
    for (std::size_t channel = 0; channel < 3; ++channel) {
      Picks& of = picks[channel];
      for (std::size_t i = 0; i < 16; ++i) {
        const std::size_t byte = 3 * (i % 8) + channel;
        const bool second = i >= 8;
        of.upper[i] = static_cast<std::uint8_t>(!second && byte < 16 ? byte : 0x80);
        of.lower[i] = static_cast<std::uint8_t>(second && byte < 16 ? byte : 0x80);
        of.ends[i] = static_cast<std::uint8_t>(byte < 16 ? 0x80 : byte - 16 + (second ? 8 : 0));
      }
    }
    return picks;
  }();
};

// Bytes B G R of four.
template <class Lanes>
struct PairedTexels<Lanes, Xrgb, 4> {
  static constexpr int kSources = 1;
  static constexpr int kOfSource = 3;
  CUPOLA_INLINE static const std::uint8_t* first(const ViewTexels& view, int, int x, int y) {
    return view.window(x, y);
  }
  CUPOLA_INLINE static TwoRows<3> two_rows(const ViewTexels&, const std::uint8_t* row,
                                           std::ptrdiff_t stride) {
    using Rows = PairedRows<Lanes>;
    const BytesOfFour upper = Rows::bytes_of_four(row);
    const BytesOfFour lower = Rows::bytes_of_four(row + stride);
    return {{_mm_unpacklo_epi64(upper.last_two, lower.last_two),
             _mm_unpackhi_epi64(upper.first_two, lower.first_two),
             _mm_unpacklo_epi64(upper.first_two, lower.first_two)}};
  }
};

// Either byte of two.
template <class Lanes>
struct PairedTexels<Lanes, Luma, 2> {
  static constexpr int kSources = 1;
  static constexpr int kOfSource = 1;
  CUPOLA_INLINE static const std::uint8_t* first(const ViewTexels& view, int, int x, int y) {
    return view.window(x, y);
  }
  CUPOLA_INLINE static TwoRows<1> two_rows(const ViewTexels& view, const std::uint8_t* row,
                                           std::ptrdiff_t stride) {
    using Rows = PairedRows<Lanes>;
    const __m128i shift = _mm_cvtsi32_si128(static_cast<int>(8 * view.channel[0]));
    return {{_mm_packus_epi16(Rows::low(_mm_srl_epi16(Rows::load(row), shift)),
                              Rows::low(_mm_srl_epi16(Rows::load(row + stride), shift)))}};
  }
};

// Both bytes of two.
template <class Lanes>
struct PairedTexels<Lanes, Chroma, 2> {
  static constexpr int kSources = 1;
  static constexpr int kOfSource = 2;
  CUPOLA_INLINE static const std::uint8_t* first(const ViewTexels& view, int, int x, int y) {
    return view.window(x, y);
  }
  CUPOLA_INLINE static TwoRows<2> two_rows(const ViewTexels&, const std::uint8_t* row,
                                           std::ptrdiff_t stride) {
    using Rows = PairedRows<Lanes>;
    return Rows::apart(Rows::load(row), Rows::load(row + stride));
  }
};

// One channel of 16 bits: the bytes of U V U V ... are the low and high ones of Y.
inline constexpr int kOf16Bits = 32;
template <class Lanes>
struct PairedTexels<Lanes, Luma, kOf16Bits> : PairedTexels<Lanes, Chroma, 2> {};

// Two channels of 16 bits by turns.
template <class Lanes>
struct PairedTexels<Lanes, Chroma, kOf16Bits> {
  static constexpr int kSources = 1;
  static constexpr int kOfSource = 4;
  CUPOLA_INLINE static const std::uint8_t* first(const ViewTexels& view, int, int x, int y) {
    return view.window(x, y);
  }
  CUPOLA_INLINE static TwoRows<4> two_rows(const ViewTexels&, const std::uint8_t* row,
                                           std::ptrdiff_t stride) {
    using Rows = PairedRows<Lanes>;
    const BytesOfFour upper = Rows::bytes_of_four(row);
    const BytesOfFour lower = Rows::bytes_of_four(row + stride);
    return {{_mm_unpacklo_epi64(upper.first_two, lower.first_two),
             _mm_unpackhi_epi64(upper.first_two, lower.first_two),
             _mm_unpacklo_epi64(upper.last_two, lower.last_two),
             _mm_unpackhi_epi64(upper.last_two, lower.last_two)}};
  }
};

// Every other byte of four.
template <class Lanes>
struct PairedTexels<Lanes, Chroma, 4> {
  static constexpr int kSources = 1;
  static constexpr int kOfSource = 2;
  CUPOLA_INLINE static const std::uint8_t* first(const ViewTexels& view, int, int x, int y) {
    return view.window(x, y);
  }
  CUPOLA_INLINE static TwoRows<2> two_rows(const ViewTexels& view, const std::uint8_t* row,
                                           std::ptrdiff_t stride) {
    const __m128i shift = _mm_cvtsi32_si128(static_cast<int>(8 * (view.channel[0] & 1)));
    return PairedRows<Lanes>::apart(both(row, shift), both(row + stride, shift));
  }

 private:
  CUPOLA_INLINE static __m128i both(const std::uint8_t* row, __m128i shift) {
    using Rows = PairedRows<Lanes>;
    return _mm_packus_epi16(Rows::low(_mm_srl_epi16(Rows::load(row), shift)),
                            Rows::low(_mm_srl_epi16(Rows::load(row + 16), shift)));
  }
};

}  // namespace cupola
