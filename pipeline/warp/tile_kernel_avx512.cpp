// The warp with AVX-512 VBMI and VNNI: a window of 8 x 8 texels is one register, a byte permutation gives
// every pixel its patch row, and one instruction sums four products for 16 pixels.
// SPDX-License-Identifier: MIT
#include <immintrin.h>

#include "pipeline/warp/tile_kernel.h"

#define CUPOLA_INLINE_LAMBDA __attribute__((always_inline))

namespace cupola {
namespace {

struct Channels {
  __m512i of[3];
  __m512i& operator[](int channel) { return of[channel]; }
  const __m512i& operator[](int channel) const { return of[channel]; }
};

// Where the kernel is in the table.
struct Cursor {
  const Block* block;
  const Block* last;  // of the tile, past its end
  const Window* window;
  const WeightLine* line;
};

// Masks for one row of eight texels each; as plain constants compilers would make them anew for every block.
struct RowMasks {
  __mmask8 of[kWindowSide];
  RowMasks() {
    for (int row = 0; row < kWindowSide; ++row) {
      of[row] = static_cast<__mmask8>(1 << row);
      asm("" : "+Yk"(of[row]));
    }
  }
};

// The first kRows rows of a window. They are merged by broadcasting loads under a mask: those need no shuffle
// port, which the permutations keep busy.
template <int kRows>
CUPOLA_INLINE __m512i load_rows(const std::uint8_t* texels, std::ptrdiff_t stride, const RowMasks& masks) {
  const auto row = [&](int y) {
    return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(texels + y * stride));
  };
  __m512i window = _mm512_castsi128_si512(row(0));
#pragma GCC unroll 8
  for (int y = 1; y < kRows; ++y) window = _mm512_mask_broadcastq_epi64(window, masks.of[y], row(y));
  return window;
}

template <int kRows>
CUPOLA_INLINE Channels load_channels(const ViewTexels& view, const Window& window, const RowMasks& masks) {
  const std::uint8_t* texels = view.window(window.x, window.y);
  return {{load_rows<kRows>(texels, view.stride, masks),
           load_rows<kRows>(texels + view.channel[1], view.stride, masks),
           load_rows<kRows>(texels + view.channel[2], view.stride, masks)}};
}

CUPOLA_INLINE Channels load_windows(const ViewTexels& view, const Window& window, const RowMasks& masks) {
  switch ((window.used + 1) / 2) {
    case 0:
    case 1:
      return load_channels<2>(view, window, masks);
    case 2:
      return load_channels<4>(view, window, masks);
    case 3:
      return load_channels<6>(view, window, masks);
    default:
      return load_channels<8>(view, window, masks);
  }
}

CUPOLA_INLINE __m512i next_line(const WeightLine*& line) {
  prefetch_after(line);
  return _mm512_load_si512(line++);
}

// Calls step() `rows` times, 1 to 8, without a loop.
template <class Step>
CUPOLA_INLINE void repeat_rows(int rows, Step&& step) {
  switch (rows) {
    case 8:
      step();
      [[fallthrough]];
    case 7:
      step();
      [[fallthrough]];
    case 6:
      step();
      [[fallthrough]];
    case 5:
      step();
      [[fallthrough]];
    case 4:
      step();
      [[fallthrough]];
    case 3:
      step();
      [[fallthrough]];
    case 2:
      step();
      [[fallthrough]];
    default:
      step();
  }
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

// By a count a lane: shifts by one count for all need the shuffle port.
CUPOLA_INLINE __m512i shifted(__m512i sum, const Block& block) {
  return _mm512_srav_epi32(sum, _mm512_set1_epi32(static_cast<int>(block.bits)));
}

CUPOLA_INLINE __m512i clamped(__m512i value) {
  return _mm512_min_epi32(_mm512_max_epi32(value, _mm512_setzero_si512()), _mm512_set1_epi32(255));
}

// Apart, so that it takes no mask register from the loops.
[[gnu::noinline]] __m512i only_covered(__m512i pixels, std::uint16_t covered) {
  return _mm512_mask_mov_epi32(_mm512_set1_epi32(static_cast<int>(kBlackXrgb)), covered, pixels);
}

// Sixteen pixels, each 0 to 255 a channel, into the block's four rows.
template <bool kAcross>
CUPOLA_INLINE void store(const Channels& rgb, const Block& block, const TileImage<Xrgb>& image) {
  const __m512i red_green = _mm512_or_si512(_mm512_slli_epi32(rgb[0], 16), _mm512_slli_epi32(rgb[1], 8));
  __m512i black = _mm512_set1_epi32(static_cast<int>(kBlackXrgb));
  asm("" : "+v"(black));  // kept in a register
  __m512i pixels = _mm512_ternarylogic_epi32(red_green, rgb[2], black, 0xfe);
  if (block.covered != kAllPixels) [[unlikely]]
    pixels = only_covered(pixels, block.covered);
  if constexpr (kAcross) pixels = _mm512_shuffle_epi32(pixels, static_cast<_MM_PERM_ENUM>(0x1b));
  Xrgb* out = image.corner + image.offset<kAcross>(block.at);
  const auto row = [&](int y) { return reinterpret_cast<__m128i*>(out + y * image.stride); };
  _mm_storeu_si128(row(0), _mm512_castsi512_si128(pixels));
  _mm_storeu_si128(row(1), _mm512_extracti32x4_epi32(pixels, 1));
  _mm_storeu_si128(row(2), _mm512_extracti32x4_epi32(pixels, 2));
  _mm_storeu_si128(row(3), _mm512_extracti32x4_epi32(pixels, 3));
}

// The run_ functions go on as long as blocks are of their kind, so that constants stay in registers.

// kSigned: bytes are weights plus kBias8, whose share is summed beside and taken off again.
template <bool kSigned, bool kAcross>
void run_bytes(Cursor& at, const TileImage<Xrgb>& image) {
  // Texels go in less 128 as the signed factor: 128 * 2^bits puts it back, 2^(bits - 1) rounds.
  static constexpr auto kStart = [] {
    std::array<std::int32_t, 16> start{};
    for (int bits = 1; bits < 16; ++bits) start[static_cast<std::size_t>(bits)] = (257 << bits) >> 1;
    return start;
  }();
  const __m512i sign = _mm512_set1_epi8(static_cast<char>(0x80));
  const __m512i bias = _mm512_set1_epi8(kBias8);
  const __m512i next_row = _mm512_set1_epi8(kWindowSide);
  const RowMasks masks;
  const Block* block = at.block;
  const Window* window = at.window;
  const WeightLine* line = at.line;
  do {
    const __m512i start = _mm512_set1_epi32(kStart[block->bits]);
    Channels sum{{start, start, start}};
    Channels biased{};
    for (const Window* end = window + block->window_count; window != end; ++window) {
      const ViewTexels& view = image.views[window->view];
      Channels texels = load_windows(view, *window, masks);
      for (int channel = 0; channel < 3; ++channel) texels[channel] = _mm512_xor_si512(texels[channel], sign);
      __m512i index = patch_index(*window, flip_of(view));
      repeat_rows(window->rows, [&]() CUPOLA_INLINE_LAMBDA {
        const __m512i weights = next_line(line);
        for (int channel = 0; channel < 3; ++channel) {
          const __m512i patch = _mm512_permutexvar_epi8(index, texels[channel]);
          sum[channel] = _mm512_dpbusd_epi32(sum[channel], weights, patch);
          if constexpr (kSigned) biased[channel] = _mm512_dpbusd_epi32(biased[channel], bias, patch);
        }
        index = _mm512_add_epi8(index, next_row);
      });
    }
    for (int channel = 0; channel < 3; ++channel) {
      if constexpr (kSigned) {
        sum[channel] = clamped(shifted(_mm512_sub_epi32(sum[channel], biased[channel]), *block));
      } else {
        sum[channel] = shifted(sum[channel], *block);
      }
    }
    store<kAcross>(sum, *block, image);
    ++block;
  } while (block != at.last && block->kind == (kSigned ? BlockKind::kSigned8 : BlockKind::kNarrow8));
  at = {block, at.last, window, line};
}

CUPOLA_INLINE Channels finish16(const Channels& high, const Channels& low, const Block& block) {
  Channels rgb;
  const __m512i one = _mm512_set1_epi32(1);
  const __m512i half = _mm512_sllv_epi32(one, _mm512_set1_epi32(static_cast<int>(block.bits - 1)));
  for (int channel = 0; channel < 3; ++channel) {
    rgb[channel] = clamped(shifted(_mm512_add_epi32(join(high[channel], low[channel]), half), block));
  }
  return rgb;
}

template <bool kAcross>
void run_pairs(Cursor& at, const TileImage<Xrgb>& image) {
  const __m512i next_row = _mm512_set1_epi8(kWindowSide);
  const RowMasks masks;
  const Block* block = at.block;
  const Window* window = at.window;
  const WeightLine* line = at.line;
  do {
    Channels high{};
    Channels low{};
    for (const Window* end = window + block->window_count; window != end; ++window) {
      const ViewTexels& view = image.views[window->view];
      const Channels texels = load_windows(view, *window, masks);
      __m512i index = patch_index(*window, flip_of(view));
      repeat_rows(window->rows, [&]() CUPOLA_INLINE_LAMBDA {
        const __m512i weights_high = next_line(line);
        const __m512i weights_low = next_line(line);
        for (int channel = 0; channel < 3; ++channel) {
          const __m512i patch = _mm512_permutexvar_epi8(index, texels[channel]);
          high[channel] = _mm512_dpbusd_epi32(high[channel], patch, weights_high);
          low[channel] = _mm512_dpbusd_epi32(low[channel], patch, weights_low);
        }
        index = _mm512_add_epi8(index, next_row);
      });
    }
    store<kAcross>(finish16(high, low, *block), *block, image);
    ++block;
  } while (block != at.last && block->kind == BlockKind::kNarrow16);
  at = {block, at.last, window, line};
}

// One block: its windows are many.
template <bool kAcross>
void run_wide(Cursor& at, const TileImage<Xrgb>& image) {
  const __m512i in_order =
      _mm512_set_epi64(0x3f3e3d3c3b3a3938, 0x3736353433323130, 0x2f2e2d2c2b2a2928, 0x2726252423222120,
                       0x1f1e1d1c1b1a1918, 0x1716151413121110, 0x0f0e0d0c0b0a0908, 0x0706050403020100);
  const RowMasks masks;
  alignas(64) std::array<std::array<std::int32_t, kPixelsInBlock>, 3> sums{};
  const WeightLine* line = at.line;
  const Window* window = at.window;
  for (const Window* end = window + at.block->window_count; window != end;) {
    const int pixel = window->start[0];
    Channels high{};
    Channels low{};
    for (; window != end && window->start[0] == pixel; ++window, line += 2) {
      const ViewTexels& view = image.views[window->view];
      const Channels texels = load_windows(view, *window, masks);
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
  store<kAcross>(finish16(Channels{}, total, *at.block), *at.block, image);
  at = {at.block + 1, at.last, window, line};
}

template <bool kAcross>
void run_image(const WarpTable& table, const Tile& tile, const TileImage<Xrgb>& image) {
  const Block* first = table.blocks.data() + tile.first_block;
  Cursor at{first, first + tile.block_count, table.windows.data() + tile.first_window,
            table.lines.data() + tile.first_line};
  while (at.block != at.last) {
    switch (at.block->kind) {
      case BlockKind::kNarrow8:
        run_bytes<false, kAcross>(at, image);
        break;
      case BlockKind::kSigned8:
        run_bytes<true, kAcross>(at, image);
        break;
      case BlockKind::kNarrow16:
        run_pairs<kAcross>(at, image);
        break;
      case BlockKind::kWide16:
        run_wide<kAcross>(at, image);
        break;
    }
  }
}

}  // namespace

void run_tile_avx512(const WarpTable& table, const Tile& tile,
                     std::span<const TileImage<Xrgb>> images) noexcept {
  for (const TileImage<Xrgb>& image : images) {
    if (image.across) {
      run_image<true>(table, tile, image);
    } else {
      run_image<false>(table, tile, image);
    }
  }
}

}  // namespace cupola
