// The warp with SSE4.1: four pixels a register.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/tile_kernel_pairs.h"

namespace cupola {
namespace {

// What PairKernel asks of a register: names say what intrinsics do, 8, 16 and 32 are bits.
struct Sse4 {
  using Register = __m128i;
  static constexpr int kGroups = 1;

  CUPOLA_INLINE static Register load(const void* bytes) {
    return _mm_load_si128(static_cast<const __m128i*>(bytes));
  }
  CUPOLA_INLINE static Register gather(const std::uint8_t* bytes, const std::size_t* offset) {
    return load(bytes + offset[0]);
  }
  CUPOLA_INLINE static Register all(__m128i bytes) { return bytes; }
  CUPOLA_INLINE static Register all8(int value) { return _mm_set1_epi8(static_cast<char>(value)); }
  CUPOLA_INLINE static Register all16(int value) { return _mm_set1_epi16(static_cast<short>(value)); }
  CUPOLA_INLINE static Register all32(int value) { return _mm_set1_epi32(value); }

  CUPOLA_INLINE static Register shuffle(Register a, Register index) { return _mm_shuffle_epi8(a, index); }
  CUPOLA_INLINE static Register reversed32(Register a) { return _mm_shuffle_epi32(a, 0x1b); }
  CUPOLA_INLINE static Register either(Register a, Register b) { return _mm_or_si128(a, b); }
  CUPOLA_INLINE static Register both(Register a, Register b) { return _mm_and_si128(a, b); }
  CUPOLA_INLINE static Register exclusive_or(Register a, Register b) { return _mm_xor_si128(a, b); }
  CUPOLA_INLINE static Register equal32(Register a, Register b) { return _mm_cmpeq_epi32(a, b); }

  CUPOLA_INLINE static Register add8(Register a, Register b) { return _mm_add_epi8(a, b); }
  CUPOLA_INLINE static Register add8_saturated(Register a, Register b) { return _mm_adds_epu8(a, b); }
  CUPOLA_INLINE static Register sub8(Register a, Register b) { return _mm_sub_epi8(a, b); }
  CUPOLA_INLINE static Register sub16(Register a, Register b) { return _mm_sub_epi16(a, b); }
  CUPOLA_INLINE static Register add32(Register a, Register b) { return _mm_add_epi32(a, b); }
  // Unsigned by signed bytes, two neighbours summed.
  CUPOLA_INLINE static Register multiply(Register u, Register s) { return _mm_maddubs_epi16(u, s); }
  CUPOLA_INLINE static Register sum_two(Register a, Register times) { return _mm_madd_epi16(a, times); }
  template <int kBits>
  CUPOLA_INLINE static Register shift_left(Register a) {
    return _mm_slli_epi32(a, kBits);
  }
  CUPOLA_INLINE static Register shift_right(Register a, int bits) {
    return _mm_sra_epi32(a, _mm_cvtsi32_si128(bits));
  }
  template <int kMost>
  CUPOLA_INLINE static Register clamp(Register a) {
    return _mm_min_epi32(_mm_max_epi32(a, _mm_setzero_si128()), all32(kMost));
  }

  // Four pixels a row, 32 bits each; of 16 and of 64 bits, the latter from the first and the second half.
  CUPOLA_INLINE static void store_rows(Register pixels, void* out, std::ptrdiff_t) {
    _mm_storeu_si128(static_cast<__m128i*>(out), pixels);
  }
  CUPOLA_INLINE static void store_rows16(Register pixels, Luma* out, std::ptrdiff_t) {
    _mm_storel_epi64(reinterpret_cast<__m128i*>(out), _mm_packus_epi32(pixels, pixels));
  }
  CUPOLA_INLINE static void store_rows64(Register first, Register second, Rgb16* out, std::ptrdiff_t) {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out), _mm_unpacklo_epi32(first, second));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + 2), _mm_unpackhi_epi32(first, second));
  }
};

}  // namespace

void run_tile_sse4(const WarpTable& table, const Tile& tile,
                   std::span<const TileImage<Xrgb>> images) noexcept {
  PairKernel<Sse4, Xrgb, 1>::run(table, tile, images);
}

void run_rgb3_sse4(const WarpTable& table, const Tile& tile,
                   std::span<const TileImage<Xrgb>> images) noexcept {
  PairKernel<Sse4, Xrgb, 3>::run(table, tile, images);
}

void run_rgb4_sse4(const WarpTable& table, const Tile& tile,
                   std::span<const TileImage<Xrgb>> images) noexcept {
  PairKernel<Sse4, Xrgb, 4>::run(table, tile, images);
}

void run_wide_sse4(const WarpTable& table, const Tile& tile,
                   std::span<const TileImage<Rgb16>> images) noexcept {
  PairKernel<Sse4, Rgb16, 2>::run(table, tile, images);
}

void run_linear_sse4(const WarpTable& table, const Tile& tile,
                     std::span<const TileImage<Rgb16>> images) noexcept {
  PairKernel<Sse4, Rgb16, 1>::run(table, tile, images);
}

void run_wide_linear_sse4(const WarpTable& table, const Tile& tile,
                          std::span<const TileImage<Rgb16>> images) noexcept {
  PairKernel<Sse4, Rgb16, kLightOf16>::run(table, tile, images);
}

void run_luma1_sse4(const WarpTable& table, const Tile& tile,
                    std::span<const TileImage<Luma>> images) noexcept {
  PairKernel<Sse4, Luma, 1>::run(table, tile, images);
}

void run_luma2_sse4(const WarpTable& table, const Tile& tile,
                    std::span<const TileImage<Luma>> images) noexcept {
  PairKernel<Sse4, Luma, 2>::run(table, tile, images);
}

void run_chroma1_sse4(const WarpTable& table, const Tile& tile,
                      std::span<const TileImage<Chroma>> images) noexcept {
  PairKernel<Sse4, Chroma, 1>::run(table, tile, images);
}

void run_chroma2_sse4(const WarpTable& table, const Tile& tile,
                      std::span<const TileImage<Chroma>> images) noexcept {
  PairKernel<Sse4, Chroma, 2>::run(table, tile, images);
}

void run_chroma4_sse4(const WarpTable& table, const Tile& tile,
                      std::span<const TileImage<Chroma>> images) noexcept {
  PairKernel<Sse4, Chroma, 4>::run(table, tile, images);
}

void run_wide_luma_sse4(const WarpTable& table, const Tile& tile,
                        std::span<const TileImage<Luma>> images) noexcept {
  PairKernel<Sse4, Luma, kOf16Bits>::run(table, tile, images);
}

void run_wide_chroma_sse4(const WarpTable& table, const Tile& tile,
                          std::span<const TileImage<Chroma>> images) noexcept {
  PairKernel<Sse4, Chroma, kOf16Bits>::run(table, tile, images);
}

}  // namespace cupola
