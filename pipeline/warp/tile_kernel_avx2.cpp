// The warp with AVX2: eight pixels a register.
// SPDX-License-Identifier: MIT
#include <immintrin.h>

#include "pipeline/warp/tile_kernel_pairs.h"

namespace cupola {
namespace {

// What PairKernel asks of a register: names say what intrinsics do, 8, 16 and 32 are bits.
struct Avx2 {
  using Register = __m256i;
  static constexpr int kGroups = 2;

  CUPOLA_INLINE static Register load(const void* bytes) {
    return _mm256_load_si256(static_cast<const __m256i*>(bytes));
  }
  CUPOLA_INLINE static Register gather(const std::uint8_t* bytes, const std::size_t* offset) {
    const auto group = [&](int i) {
      return _mm_load_si128(reinterpret_cast<const __m128i*>(bytes + offset[i]));
    };
    return _mm256_inserti128_si256(_mm256_castsi128_si256(group(0)), group(1), 1);
  }
  CUPOLA_INLINE static Register all(__m128i bytes) { return _mm256_broadcastsi128_si256(bytes); }
  CUPOLA_INLINE static Register all8(int value) { return _mm256_set1_epi8(static_cast<char>(value)); }
  CUPOLA_INLINE static Register all16(int value) { return _mm256_set1_epi16(static_cast<short>(value)); }
  CUPOLA_INLINE static Register all32(int value) { return _mm256_set1_epi32(value); }

  CUPOLA_INLINE static Register shuffle(Register a, Register index) { return _mm256_shuffle_epi8(a, index); }
  CUPOLA_INLINE static Register reversed32(Register a) { return _mm256_shuffle_epi32(a, 0x1b); }
  CUPOLA_INLINE static Register either(Register a, Register b) { return _mm256_or_si256(a, b); }
  CUPOLA_INLINE static Register both(Register a, Register b) { return _mm256_and_si256(a, b); }
  CUPOLA_INLINE static Register exclusive_or(Register a, Register b) { return _mm256_xor_si256(a, b); }
  CUPOLA_INLINE static Register equal32(Register a, Register b) { return _mm256_cmpeq_epi32(a, b); }

  CUPOLA_INLINE static Register add8(Register a, Register b) { return _mm256_add_epi8(a, b); }
  CUPOLA_INLINE static Register add8_saturated(Register a, Register b) { return _mm256_adds_epu8(a, b); }
  CUPOLA_INLINE static Register sub8(Register a, Register b) { return _mm256_sub_epi8(a, b); }
  CUPOLA_INLINE static Register sub16(Register a, Register b) { return _mm256_sub_epi16(a, b); }
  CUPOLA_INLINE static Register add32(Register a, Register b) { return _mm256_add_epi32(a, b); }
  // Unsigned by signed bytes, two neighbours summed.
  CUPOLA_INLINE static Register multiply(Register u, Register s) { return _mm256_maddubs_epi16(u, s); }
  CUPOLA_INLINE static Register sum_two(Register a, Register times) { return _mm256_madd_epi16(a, times); }
  template <int kBits>
  CUPOLA_INLINE static Register shift_left(Register a) {
    return _mm256_slli_epi32(a, kBits);
  }
  CUPOLA_INLINE static Register shift_right(Register a, int bits) {
    return _mm256_sra_epi32(a, _mm_cvtsi32_si128(bits));
  }
  template <int kMost>
  CUPOLA_INLINE static Register clamp(Register a) {
    return _mm256_min_epi32(_mm256_max_epi32(a, _mm256_setzero_si256()), all32(kMost));
  }

  // Four pixels a row, 32 bits each; of 16 and of 64 bits, the latter from the first and the second half.
  template <class Pixel>
  CUPOLA_INLINE static void store_rows(Register pixels, Pixel* out, std::ptrdiff_t stride) {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out), _mm256_castsi256_si128(pixels));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + stride), _mm256_extracti128_si256(pixels, 1));
  }
  CUPOLA_INLINE static void store_rows16(Register pixels, Luma* out, std::ptrdiff_t stride) {
    const __m256i packed = _mm256_packus_epi32(pixels, pixels);
    _mm_storel_epi64(reinterpret_cast<__m128i*>(out), _mm256_castsi256_si128(packed));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(out + stride), _mm256_extracti128_si256(packed, 1));
  }
  CUPOLA_INLINE static void store_rows64(Register first, Register second, Rgb16* out, std::ptrdiff_t stride) {
    store_rows(_mm256_unpacklo_epi32(first, second), out, stride);
    store_rows(_mm256_unpackhi_epi32(first, second), out + 2, stride);
  }
};

}  // namespace

void run_tile_avx2(const WarpTable& table, const Tile& tile,
                   std::span<const TileImage<Xrgb>> images) noexcept {
  PairKernel<Avx2, Xrgb, 1>::run(table, tile, images);
}

void run_rgb3_avx2(const WarpTable& table, const Tile& tile,
                   std::span<const TileImage<Xrgb>> images) noexcept {
  PairKernel<Avx2, Xrgb, 3>::run(table, tile, images);
}

void run_rgb4_avx2(const WarpTable& table, const Tile& tile,
                   std::span<const TileImage<Xrgb>> images) noexcept {
  PairKernel<Avx2, Xrgb, 4>::run(table, tile, images);
}

void run_wide_avx2(const WarpTable& table, const Tile& tile,
                   std::span<const TileImage<Rgb16>> images) noexcept {
  PairKernel<Avx2, Rgb16, 2>::run(table, tile, images);
}

void run_linear_avx2(const WarpTable& table, const Tile& tile,
                     std::span<const TileImage<Rgb16>> images) noexcept {
  PairKernel<Avx2, Rgb16, 1>::run(table, tile, images);
}

void run_wide_linear_avx2(const WarpTable& table, const Tile& tile,
                          std::span<const TileImage<Rgb16>> images) noexcept {
  PairKernel<Avx2, Rgb16, kLightOf16>::run(table, tile, images);
}

void run_luma1_avx2(const WarpTable& table, const Tile& tile,
                    std::span<const TileImage<Luma>> images) noexcept {
  PairKernel<Avx2, Luma, 1>::run(table, tile, images);
}

void run_luma2_avx2(const WarpTable& table, const Tile& tile,
                    std::span<const TileImage<Luma>> images) noexcept {
  PairKernel<Avx2, Luma, 2>::run(table, tile, images);
}

void run_chroma1_avx2(const WarpTable& table, const Tile& tile,
                      std::span<const TileImage<Chroma>> images) noexcept {
  PairKernel<Avx2, Chroma, 1>::run(table, tile, images);
}

void run_chroma2_avx2(const WarpTable& table, const Tile& tile,
                      std::span<const TileImage<Chroma>> images) noexcept {
  PairKernel<Avx2, Chroma, 2>::run(table, tile, images);
}

void run_chroma4_avx2(const WarpTable& table, const Tile& tile,
                      std::span<const TileImage<Chroma>> images) noexcept {
  PairKernel<Avx2, Chroma, 4>::run(table, tile, images);
}

void run_wide_luma_avx2(const WarpTable& table, const Tile& tile,
                        std::span<const TileImage<Luma>> images) noexcept {
  PairKernel<Avx2, Luma, kOf16Bits>::run(table, tile, images);
}

void run_wide_chroma_avx2(const WarpTable& table, const Tile& tile,
                          std::span<const TileImage<Chroma>> images) noexcept {
  PairKernel<Avx2, Chroma, kOf16Bits>::run(table, tile, images);
}

}  // namespace cupola
