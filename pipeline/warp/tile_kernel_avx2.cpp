// The warp with AVX2: patch rows are gathered four texels at a time, eight pixels a register.
// SPDX-License-Identifier: MIT
#include <immintrin.h>

#include "pipeline/warp/tile_kernel.h"

namespace cupola {
namespace {

// Byte offsets of eight pixels' patches from the window's first texel.
__m256i patch_offsets(const std::uint8_t* start, std::ptrdiff_t stride) {
  const __m256i starts = _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(start)));
  const __m256i rows =
      _mm256_mullo_epi32(_mm256_srli_epi32(starts, 3), _mm256_set1_epi32(static_cast<int>(stride)));
  return _mm256_add_epi32(rows, _mm256_and_si256(starts, _mm256_set1_epi32(kWindowSide - 1)));
}

__m256i gather_patch_row(const std::uint8_t* texels, __m256i offsets) {
  return _mm256_i32gather_epi32(reinterpret_cast<const int*>(texels), offsets, 1);
}

__m256i load_weights(const WeightLine* line, int half) {
  return _mm256_load_si256(reinterpret_cast<const __m256i*>(line->bytes.data() + half * 32));
}

// Sums of four neighbouring products as 32 bits; each pair fits 16 (warp_table.h).
__m256i sum_fours(__m256i unsigned_bytes, __m256i signed_bytes) {
  return _mm256_madd_epi16(_mm256_maddubs_epi16(unsigned_bytes, signed_bytes), _mm256_set1_epi16(1));
}

// Sixteen pixels of a block into its four rows.
void store_rows(__m128i pixels, std::uint8_t* out) {
  _mm_storeu_si32(out, pixels);
  _mm_storeu_si32(out + kTileSide, _mm_shuffle_epi32(pixels, 0x55));
  _mm_storeu_si32(out + 2 * kTileSide, _mm_shuffle_epi32(pixels, 0xaa));
  _mm_storeu_si32(out + 3 * kTileSide, _mm_shuffle_epi32(pixels, 0xff));
}

// 2 x 8 totals -> 16 bytes, with saturation at 0 and 255.
void store_pixels(__m256i first, __m256i second, int bits, std::uint8_t* out) {
  const __m128i shift = _mm_cvtsi32_si128(bits);
  const __m256i words = _mm256_permute4x64_epi64(
      _mm256_packs_epi32(_mm256_sra_epi32(first, shift), _mm256_sra_epi32(second, shift)), 0xd8);
  store_rows(_mm_packus_epi16(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1)), out);
}

class TileRun {
 public:
  TileRun(const WarpTable& table, std::span<const ViewTexels> views) : table_(table), views_(views) {}

  void narrow8(const Block& block, int channel, std::uint8_t* out) const {
    const __m256i flip = _mm256_set1_epi8(static_cast<char>(0x80));
    __m256i sum[2] = {bias(block.covered, block.bits), bias(block.covered >> 8, block.bits)};
    const WeightLine* line = table_.lines.data() + block.first_line;
    for (const Window& window : windows(block)) {
      const std::ptrdiff_t stride = views_[window.view].stride[channel];
      const std::uint8_t* texels = first_texel(window, channel);
      const __m256i offsets[2] = {patch_offsets(window.start.data(), stride),
                                  patch_offsets(window.start.data() + 8, stride)};
      for (int row = 0; row < window.rows; ++row, ++line, texels += stride) {
        for (int half = 0; half < 2; ++half) {
          const __m256i patch = _mm256_xor_si256(gather_patch_row(texels, offsets[half]), flip);
          sum[half] = _mm256_add_epi32(sum[half], sum_fours(load_weights(line, half), patch));
        }
      }
    }
    store_pixels(sum[0], sum[1], block.bits, out);
  }

  void narrow16(const Block& block, int channel, std::uint8_t* out) const {
    __m256i high[2] = {};
    __m256i low[2] = {};
    const WeightLine* line = table_.lines.data() + block.first_line;
    for (const Window& window : windows(block)) {
      const std::ptrdiff_t stride = views_[window.view].stride[channel];
      const std::uint8_t* texels = first_texel(window, channel);
      const __m256i offsets[2] = {patch_offsets(window.start.data(), stride),
                                  patch_offsets(window.start.data() + 8, stride)};
      for (int row = 0; row < window.rows; ++row, line += 2, texels += stride) {
        for (int half = 0; half < 2; ++half) {
          const __m256i patch = gather_patch_row(texels, offsets[half]);
          high[half] = _mm256_add_epi32(high[half], sum_fours(patch, load_weights(line, half)));
          low[half] = _mm256_add_epi32(low[half], sum_fours(patch, load_weights(line + 1, half)));
        }
      }
    }
    finish16(join(high[0], low[0]), join(high[1], low[1]), block.bits, out);
  }

  void wide16(const Block& block, int channel, std::uint8_t* out) const {
    alignas(32) std::array<std::int32_t, kPixelsInBlock> sums{};
    const WeightLine* line = table_.lines.data() + block.first_line;
    for (const Window& window : windows(block)) {
      const std::ptrdiff_t stride = views_[window.view].stride[channel];
      const std::uint8_t* texels = first_texel(window, channel);
      __m256i high = _mm256_setzero_si256();
      __m256i low = _mm256_setzero_si256();
      for (int half = 0; half < 2; ++half, texels += 4 * stride) {
        const auto row = [&](int y) {
          long long eight;
          __builtin_memcpy(&eight, texels + y * stride, sizeof eight);
          return eight;
        };
        const __m256i four_rows = _mm256_setr_epi64x(row(0), row(1), row(2), row(3));
        high = _mm256_add_epi32(high, sum_fours(four_rows, load_weights(line, half)));
        low = _mm256_add_epi32(low, sum_fours(four_rows, load_weights(line + 1, half)));
      }
      line += 2;
      sums[window.pixel] += sum_all(join(high, low));
    }
    finish16(_mm256_load_si256(reinterpret_cast<const __m256i*>(sums.data())),
             _mm256_load_si256(reinterpret_cast<const __m256i*>(sums.data() + 8)), block.bits, out);
  }

 private:
  const std::uint8_t* first_texel(const Window& window, int channel) const {
    const ViewTexels& view = views_[window.view];
    return view.plane[channel] + window.y * view.stride[channel] + window.x;
  }

  std::span<const Window> windows(const Block& block) const {
    return {table_.windows.data() + block.first_window, block.window_count};
  }

  // What makes signed texels unsigned again and rounds; nothing for pixels without a footprint.
  static __m256i bias(int covered, int bits) {
    const __m256i pixel = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i has = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(covered), pixel), pixel);
    return _mm256_and_si256(has, _mm256_set1_epi32((257 << bits) >> 1));
  }

  static __m256i join(__m256i high, __m256i low) { return _mm256_add_epi32(_mm256_slli_epi32(high, 7), low); }

  static int sum_all(__m256i eight) {
    __m128i four = _mm_add_epi32(_mm256_castsi256_si128(eight), _mm256_extracti128_si256(eight, 1));
    four = _mm_add_epi32(four, _mm_shuffle_epi32(four, 0x4e));
    return _mm_cvtsi128_si32(_mm_add_epi32(four, _mm_shuffle_epi32(four, 0xb1)));
  }

  static void finish16(__m256i first, __m256i second, int bits, std::uint8_t* out) {
    const __m256i half = _mm256_set1_epi32(1 << (bits - 1));
    store_pixels(_mm256_add_epi32(first, half), _mm256_add_epi32(second, half), bits, out);
  }

  const WarpTable& table_;
  std::span<const ViewTexels> views_;
};

}  // namespace

void run_tile_avx2(const WarpTable& table, int tile, std::span<const ViewTexels> views,
                   TilePixels<std::uint8_t>& pixels) noexcept {
  const TileRun run(table, views);
  const Block* block = table.blocks.data() + static_cast<std::size_t>(tile) * kBlocksInTile;
  for (int i = 0; i < kBlocksInTile; ++i, ++block) {
    for (int channel = 0; channel < 3; ++channel) {
      std::uint8_t* out = pixels.channel[channel].data() + first_pixel(i);
      switch (block->kind) {
        case BlockKind::kEmpty:
          store_rows(_mm_setzero_si128(), out);
          break;
        case BlockKind::kNarrow8:
          run.narrow8(*block, channel, out);
          break;
        case BlockKind::kNarrow16:
          run.narrow16(*block, channel, out);
          break;
        case BlockKind::kWide16:
          run.wide16(*block, channel, out);
          break;
      }
    }
  }
}

}  // namespace cupola
