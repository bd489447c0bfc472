// The warp with AVX-512 VBMI and VNNI: a window of 8 x 8 texels is one register, a byte permutation gives
// every pixel its patch row, and one instruction sums four products for 16 pixels.
// SPDX-License-Identifier: MIT
#include <immintrin.h>

#include "pipeline/warp/tile_kernel.h"

namespace cupola {
namespace {

struct Channels {
  __m512i of[3];
  __m512i& operator[](int channel) { return of[channel]; }
  const __m512i& operator[](int channel) const { return of[channel]; }
};

// What a block's sum reads.
struct Source {
  const Block& block;
  const Window* window;
  const WeightLine* line;
  const ViewTexels* views;
};

// The first `used` rows of a window, some more perhaps. Rows are merged by broadcasting loads under a mask:
// those need no shuffle port, which the permutations keep busy.
CUPOLA_INLINE __m512i load_window(const std::uint8_t* texels, std::ptrdiff_t stride, int used) {
  const auto row = [&](int y) {
    return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(texels + y * stride));
  };
  __m512i window = _mm512_castsi128_si512(row(0));
  window = _mm512_mask_broadcastq_epi64(window, 1 << 1, row(1));
  if (used > 2) {
    window = _mm512_mask_broadcastq_epi64(window, 1 << 2, row(2));
    window = _mm512_mask_broadcastq_epi64(window, 1 << 3, row(3));
  }
  if (used > 4) {
    window = _mm512_mask_broadcastq_epi64(window, 1 << 4, row(4));
    window = _mm512_mask_broadcastq_epi64(window, 1 << 5, row(5));
  }
  if (used > 6) {
    window = _mm512_mask_broadcastq_epi64(window, 1 << 6, row(6));
    window = _mm512_mask_broadcastq_epi64(window, static_cast<__mmask8>(1 << 7), row(7));
  }
  return window;
}

CUPOLA_INLINE Channels load_windows(const ViewTexels& view, const Window& window) {
  Channels texels;
  for (int channel = 0; channel < 3; ++channel) {
    texels[channel] =
        load_window(view.window(channel, window.x, window.y), view.stride[channel], window.used);
  }
  return texels;
}

CUPOLA_INLINE __m512i flip_of(const ViewTexels& view) {
  return _mm512_set1_epi32(static_cast<int>(view.flip));
}

// Where in the window each pixel's first patch row lies: 4 bytes a pixel.
CUPOLA_INLINE __m512i patch_index(const Window& window, __m512i flip) {
  const __m512i four_times = _mm512_setr_epi32(
      0x00000000, 0x01010101, 0x02020202, 0x03030303, 0x04040404, 0x05050505, 0x06060606, 0x07070707,
      0x08080808, 0x09090909, 0x0a0a0a0a, 0x0b0b0b0b, 0x0c0c0c0c, 0x0d0d0d0d, 0x0e0e0e0e, 0x0f0f0f0f);
  const __m128i start = _mm_loadu_si128(reinterpret_cast<const __m128i*>(window.start.data()));
  const __m512i corner = _mm512_permutexvar_epi8(four_times, _mm512_castsi128_si512(start));
  return _mm512_xor_si512(_mm512_add_epi8(corner, _mm512_set1_epi32(0x03020100)), flip);
}

CUPOLA_INLINE __m512i join(__m512i high, __m512i low) {
  return _mm512_add_epi32(_mm512_slli_epi32(high, 7), low);
}

CUPOLA_INLINE __m512i shifted(__m512i sum, int bits) {
  return _mm512_sra_epi32(sum, _mm_cvtsi32_si128(bits));
}

CUPOLA_INLINE __m512i clamped(__m512i value) {
  return _mm512_min_epi32(_mm512_max_epi32(value, _mm512_setzero_si512()), _mm512_set1_epi32(255));
}

// kSigned: bytes are weights plus kBias8, whose share is summed beside and taken off again.
template <bool kSigned>
CUPOLA_INLINE Channels sum_bytes(const Source& from) {
  // Texels go in less 128 as the signed factor: 128 * 2^bits puts it back, 2^(bits - 1) rounds.
  const int bits = from.block.bits;
  const __m512i start = _mm512_set1_epi32((257 << bits) >> 1);
  const __m512i sign = _mm512_set1_epi8(static_cast<char>(0x80));
  const __m512i bias = _mm512_set1_epi8(kBias8);
  Channels sum{{start, start, start}};
  Channels biased{};
  const __m512i next_row = _mm512_set1_epi8(kWindowSide);
  const WeightLine* line = from.line;
  const Window* window = from.window;
  for (const Window* end = window + from.block.window_count; window != end; ++window) {
    const ViewTexels& view = from.views[window->view];
    Channels texels = load_windows(view, *window);
    for (int channel = 0; channel < 3; ++channel) texels[channel] = _mm512_xor_si512(texels[channel], sign);
    __m512i index = patch_index(*window, flip_of(view));
    for (const WeightLine* last = line + window->rows; line != last; ++line) {
      const __m512i weights = _mm512_load_si512(line);
      for (int channel = 0; channel < 3; ++channel) {
        const __m512i patch = _mm512_permutexvar_epi8(index, texels[channel]);
        sum[channel] = _mm512_dpbusd_epi32(sum[channel], weights, patch);
        if constexpr (kSigned) biased[channel] = _mm512_dpbusd_epi32(biased[channel], bias, patch);
      }
      index = _mm512_add_epi8(index, next_row);
      prefetch_after(line);
    }
  }
  for (int channel = 0; channel < 3; ++channel) {
    if constexpr (kSigned) {
      sum[channel] = clamped(shifted(_mm512_sub_epi32(sum[channel], biased[channel]), bits));
    } else {
      sum[channel] = shifted(sum[channel], bits);
    }
  }
  return sum;
}

CUPOLA_INLINE Channels finish16(const Channels& high, const Channels& low, int bits) {
  Channels rgb;
  const __m512i half = _mm512_set1_epi32(1 << (bits - 1));
  for (int channel = 0; channel < 3; ++channel) {
    rgb[channel] = clamped(shifted(_mm512_add_epi32(join(high[channel], low[channel]), half), bits));
  }
  return rgb;
}

CUPOLA_INLINE Channels sum_pairs(const Source& from) {
  Channels high{};
  Channels low{};
  const __m512i next_row = _mm512_set1_epi8(kWindowSide);
  const WeightLine* line = from.line;
  const Window* window = from.window;
  for (const Window* end = window + from.block.window_count; window != end; ++window) {
    const ViewTexels& view = from.views[window->view];
    const Channels texels = load_windows(view, *window);
    __m512i index = patch_index(*window, flip_of(view));
    for (const WeightLine* last = line + 2 * window->rows; line != last; line += 2) {
      const __m512i weights_high = _mm512_load_si512(line);
      const __m512i weights_low = _mm512_load_si512(line + 1);
      for (int channel = 0; channel < 3; ++channel) {
        const __m512i patch = _mm512_permutexvar_epi8(index, texels[channel]);
        high[channel] = _mm512_dpbusd_epi32(high[channel], patch, weights_high);
        low[channel] = _mm512_dpbusd_epi32(low[channel], patch, weights_low);
      }
      index = _mm512_add_epi8(index, next_row);
      prefetch_after(line);
    }
  }
  return finish16(high, low, from.block.bits);
}

Channels sum_wide(const Source& from) {
  const __m512i in_order =
      _mm512_set_epi64(0x3f3e3d3c3b3a3938, 0x3736353433323130, 0x2f2e2d2c2b2a2928, 0x2726252423222120,
                       0x1f1e1d1c1b1a1918, 0x1716151413121110, 0x0f0e0d0c0b0a0908, 0x0706050403020100);
  alignas(64) std::array<std::array<std::int32_t, kPixelsInBlock>, 3> sums{};
  const WeightLine* line = from.line;
  const Window* window = from.window;
  for (const Window* end = window + from.block.window_count; window != end;) {
    const int pixel = window->start[0];
    Channels high{};
    Channels low{};
    for (; window != end && window->start[0] == pixel; ++window, line += 2) {
      const ViewTexels& view = from.views[window->view];
      const Channels texels = load_windows(view, *window);
      const __m512i turned = _mm512_xor_si512(in_order, flip_of(view));
      const __m512i weights_high = _mm512_permutexvar_epi8(turned, _mm512_load_si512(line));
      const __m512i weights_low = _mm512_permutexvar_epi8(turned, _mm512_load_si512(line + 1));
      for (int channel = 0; channel < 3; ++channel) {
        high[channel] = _mm512_dpbusd_epi32(high[channel], texels[channel], weights_high);
        low[channel] = _mm512_dpbusd_epi32(low[channel], texels[channel], weights_low);
      }
    }
    for (int channel = 0; channel < 3; ++channel) {
      sums[channel][pixel] = _mm512_reduce_add_epi32(join(high[channel], low[channel]));
    }
  }
  Channels total;
  for (int channel = 0; channel < 3; ++channel) total[channel] = _mm512_load_si512(sums[channel].data());
  return finish16(Channels{}, total, from.block.bits);
}

CUPOLA_INLINE Channels sum_block(const Source& from) {
  switch (from.block.kind) {
    case BlockKind::kNarrow8:
      return sum_bytes<false>(from);
    case BlockKind::kSigned8:
      return sum_bytes<true>(from);
    case BlockKind::kNarrow16:
      return sum_pairs(from);
    case BlockKind::kWide16:
      break;
  }
  return sum_wide(from);
}

// Sixteen pixels, each 0 to 255 a channel, into the block's four rows.
template <bool kAcross>
CUPOLA_INLINE void store(const Channels& rgb, const Block& block, const TileImage<Xrgb>& image) {
  const __m512i red_green = _mm512_or_si512(_mm512_slli_epi32(rgb[0], 16), _mm512_slli_epi32(rgb[1], 8));
  const __m512i black = _mm512_set1_epi32(static_cast<int>(kBlackXrgb));
  const __m512i all = _mm512_ternarylogic_epi32(red_green, rgb[2], black, 0xfe);
  __m512i pixels = _mm512_mask_mov_epi32(black, block.covered, all);
  if constexpr (kAcross) pixels = _mm512_shuffle_epi32(pixels, static_cast<_MM_PERM_ENUM>(0x1b));
  Xrgb* out = image.block(block.at);
  const auto row = [&](int y) { return reinterpret_cast<__m128i*>(out + y * image.stride); };
  _mm_storeu_si128(row(0), _mm512_castsi512_si128(pixels));
  _mm_storeu_si128(row(1), _mm512_extracti32x4_epi32(pixels, 1));
  _mm_storeu_si128(row(2), _mm512_extracti32x4_epi32(pixels, 2));
  _mm_storeu_si128(row(3), _mm512_extracti32x4_epi32(pixels, 3));
}

template <bool kAcross>
void run_image(const WarpTable& table, const Tile& tile, const TileImage<Xrgb>& image) {
  const Block* block = table.blocks.data() + tile.first_block;
  const Window* window = table.windows.data() + tile.first_window;
  const WeightLine* line = table.lines.data() + tile.first_line;
  for (const Block* end = block + tile.block_count; block != end; ++block) {
    store<kAcross>(sum_block({*block, window, line, image.views.data()}), *block, image);
    window += block->window_count;
    line += block->line_count;
  }
}

}  // namespace

void run_tile_avx512(const WarpTable& table, const Tile& tile,
                     std::span<const TileImage<Xrgb>> images) noexcept {
  for (const TileImage<Xrgb>& image : images) {
    if (image.across) {
      run_image<true>(table, tile, TileImage<Xrgb>{image.views, image.corner, image.stride, true});
    } else {
      run_image<false>(table, tile, TileImage<Xrgb>{image.views, image.corner, image.stride, false});
    }
  }
}

}  // namespace cupola
