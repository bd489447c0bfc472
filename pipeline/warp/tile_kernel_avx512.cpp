// The warp with AVX-512 VBMI and VNNI: a window of 8 x 8 texels is one register, a byte permutation gives
// every pixel its patch row, and one instruction sums four products for 16 pixels. SPDX-License-Identifier:
// MIT
#include <immintrin.h>

#include "pipeline/warp/tile_kernel.h"

namespace cupola {
namespace {

// Byte i is i / 4: a pixel's value for each of its four patch columns.
__m512i repeat_each_four_times(__m128i bytes) {
  const __m512i index = _mm512_setr_epi32(
      0x00000000, 0x01010101, 0x02020202, 0x03030303, 0x04040404, 0x05050505, 0x06060606, 0x07070707,
      0x08080808, 0x09090909, 0x0a0a0a0a, 0x0b0b0b0b, 0x0c0c0c0c, 0x0d0d0d0d, 0x0e0e0e0e, 0x0f0f0f0f);
  return _mm512_permutexvar_epi8(index, _mm512_castsi128_si512(bytes));
}

__m512i load_window(const std::uint8_t* texels, std::ptrdiff_t stride) {
  const auto row = [&](int y) {
    return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(texels + y * stride));
  };
  const auto pair = [&](int y) {
    return _mm_castpd_si128(
        _mm_loadh_pd(_mm_castsi128_pd(row(y)), reinterpret_cast<const double*>(texels + (y + 1) * stride)));
  };
  const __m256i low = _mm256_inserti128_si256(_mm256_castsi128_si256(pair(0)), pair(2), 1);
  const __m256i high = _mm256_inserti128_si256(_mm256_castsi128_si256(pair(4)), pair(6), 1);
  return _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1);
}

struct Channels {
  __m512i c0, c1, c2;
};

Channels load_windows(const ViewTexels& view, const Window& window) {
  const auto load = [&](int channel) {
    return load_window(view.plane[channel] + window.y * view.stride[channel] + window.x,
                       view.stride[channel]);
  };
  return {load(0), load(1), load(2)};
}

__m512i patch_index(const Window& window) {
  const __m128i start = _mm_loadu_si128(reinterpret_cast<const __m128i*>(window.start.data()));
  return _mm512_add_epi8(repeat_each_four_times(start), _mm512_set1_epi32(0x03020100));
}

// Sixteen pixels of a block into its four rows.
void store(__m128i pixels, std::uint8_t* out) {
  _mm_storeu_si32(out, pixels);
  _mm_storeu_si32(out + kTileSide, _mm_shuffle_epi32(pixels, 0x55));
  _mm_storeu_si32(out + 2 * kTileSide, _mm_shuffle_epi32(pixels, 0xaa));
  _mm_storeu_si32(out + 3 * kTileSide, _mm_shuffle_epi32(pixels, 0xff));
}

class TileRun {
 public:
  TileRun(const WarpTable& table, std::span<const ViewTexels> views, TilePixels<std::uint8_t>& pixels)
      : table_(table), views_(views), pixels_(pixels) {}

  void narrow8(const Block& block, int at) const {
    // Texels go in less 128 as the signed factor: 128 * 2^bits puts it back, 2^(bits - 1) rounds.
    const __m512i bias = _mm512_set1_epi32((257 << block.bits) >> 1);
    const __m512i flip = _mm512_set1_epi8(static_cast<char>(0x80));
    const __m512i next_row = _mm512_set1_epi8(kWindowSide);
    Channels sum{bias, bias, bias};
    const WeightLine* line = table_.lines.data() + block.first_line;
    const Window* window = table_.windows.data() + block.first_window;
    for (const Window* end = window + block.window_count; window != end; ++window) {
      Channels texels = load_windows(views_[window->view], *window);
      texels = {_mm512_xor_si512(texels.c0, flip), _mm512_xor_si512(texels.c1, flip),
                _mm512_xor_si512(texels.c2, flip)};
      __m512i index = patch_index(*window);
      for (int row = 0; row < window->rows; ++row, ++line) {
        const __m512i weights = _mm512_load_si512(line);
        sum.c0 = _mm512_dpbusd_epi32(sum.c0, weights, _mm512_permutexvar_epi8(index, texels.c0));
        sum.c1 = _mm512_dpbusd_epi32(sum.c1, weights, _mm512_permutexvar_epi8(index, texels.c1));
        sum.c2 = _mm512_dpbusd_epi32(sum.c2, weights, _mm512_permutexvar_epi8(index, texels.c2));
        index = _mm512_add_epi8(index, next_row);
      }
    }
    const auto finish = [&](__m512i total, int channel) {
      store(_mm512_maskz_cvtepi32_epi8(block.covered, _mm512_srl_epi32(total, _mm_cvtsi32_si128(block.bits))),
            pixels_.channel[channel].data() + at);
    };
    finish(sum.c0, 0);
    finish(sum.c1, 1);
    finish(sum.c2, 2);
  }

  void narrow16(const Block& block, int at) const {
    const __m512i next_row = _mm512_set1_epi8(kWindowSide);
    Channels high{};
    Channels low{};
    const WeightLine* line = table_.lines.data() + block.first_line;
    const Window* window = table_.windows.data() + block.first_window;
    for (const Window* end = window + block.window_count; window != end; ++window) {
      const Channels texels = load_windows(views_[window->view], *window);
      __m512i index = patch_index(*window);
      for (int row = 0; row < window->rows; ++row, line += 2) {
        const __m512i weights_high = _mm512_load_si512(line);
        const __m512i weights_low = _mm512_load_si512(line + 1);
        const auto add = [&](__m512i& sum_high, __m512i& sum_low, __m512i texel) {
          const __m512i patch = _mm512_permutexvar_epi8(index, texel);
          sum_high = _mm512_dpbusd_epi32(sum_high, patch, weights_high);
          sum_low = _mm512_dpbusd_epi32(sum_low, patch, weights_low);
        };
        add(high.c0, low.c0, texels.c0);
        add(high.c1, low.c1, texels.c1);
        add(high.c2, low.c2, texels.c2);
        index = _mm512_add_epi8(index, next_row);
      }
    }
    finish16(high.c0, low.c0, block.bits, 0, at);
    finish16(high.c1, low.c1, block.bits, 1, at);
    finish16(high.c2, low.c2, block.bits, 2, at);
  }

  void wide16(const Block& block, int at) const {
    alignas(64) std::array<std::array<std::int32_t, kPixelsInBlock>, 3> sums{};
    const WeightLine* line = table_.lines.data() + block.first_line;
    const Window* window = table_.windows.data() + block.first_window;
    for (const Window* end = window + block.window_count; window != end;) {
      const int pixel = window->pixel;
      Channels high{};
      Channels low{};
      for (; window != end && window->pixel == pixel; ++window, line += 2) {
        const Channels texels = load_windows(views_[window->view], *window);
        const __m512i weights_high = _mm512_load_si512(line);
        const __m512i weights_low = _mm512_load_si512(line + 1);
        high = {_mm512_dpbusd_epi32(high.c0, texels.c0, weights_high),
                _mm512_dpbusd_epi32(high.c1, texels.c1, weights_high),
                _mm512_dpbusd_epi32(high.c2, texels.c2, weights_high)};
        low = {_mm512_dpbusd_epi32(low.c0, texels.c0, weights_low),
               _mm512_dpbusd_epi32(low.c1, texels.c1, weights_low),
               _mm512_dpbusd_epi32(low.c2, texels.c2, weights_low)};
      }
      sums[0][pixel] = _mm512_reduce_add_epi32(join(high.c0, low.c0));
      sums[1][pixel] = _mm512_reduce_add_epi32(join(high.c1, low.c1));
      sums[2][pixel] = _mm512_reduce_add_epi32(join(high.c2, low.c2));
    }
    for (int channel = 0; channel < 3; ++channel) {
      finish16(_mm512_setzero_si512(), _mm512_load_si512(sums[channel].data()), block.bits, channel, at);
    }
  }

  void empty(int at) const {
    for (auto& channel : pixels_.channel) store(_mm_setzero_si128(), channel.data() + at);
  }

 private:
  static __m512i join(__m512i high, __m512i low) { return _mm512_add_epi32(_mm512_slli_epi32(high, 7), low); }

  void finish16(__m512i high, __m512i low, int bits, int channel, int at) const {
    const __m512i rounded = _mm512_sra_epi32(
        _mm512_add_epi32(join(high, low), _mm512_set1_epi32(1 << (bits - 1))), _mm_cvtsi32_si128(bits));
    const __m512i positive = _mm512_max_epi32(rounded, _mm512_setzero_si512());
    store(_mm512_cvtusepi32_epi8(positive), pixels_.channel[channel].data() + at);
  }

  const WarpTable& table_;
  std::span<const ViewTexels> views_;
  TilePixels<std::uint8_t>& pixels_;
};

}  // namespace

void run_tile_avx512(const WarpTable& table, int tile, std::span<const ViewTexels> views,
                     TilePixels<std::uint8_t>& pixels) noexcept {
  const TileRun run(table, views, pixels);
  const Block* block = table.blocks.data() + static_cast<std::size_t>(tile) * kBlocksInTile;
  for (int i = 0; i < kBlocksInTile; ++i, ++block) {
    const int at = first_pixel(i);
    switch (block->kind) {
      case BlockKind::kEmpty:
        run.empty(at);
        break;
      case BlockKind::kNarrow8:
        run.narrow8(*block, at);
        break;
      case BlockKind::kNarrow16:
        run.narrow16(*block, at);
        break;
      case BlockKind::kWide16:
        run.wide16(*block, at);
        break;
    }
  }
}

}  // namespace cupola
