// The warp with AVX-512 VBMI and VNNI: a window of 8 x 8 texels is one register, a byte permutation gives
// every pixel its patch row, and one instruction sums four products for 16 pixels.
// SPDX-License-Identifier: MIT
#include <immintrin.h>

#include "pipeline/warp/texels_ahead.h"
#include "pipeline/warp/tile_kernel.h"
#include "pipeline/warp/window_load_avx512.h"

namespace cupola {
namespace {

// What a kernel makes of which texels.
template <class Pixel, int kStep>
struct Form;
template <int kStep>
struct Form<Xrgb, kStep> {
  static constexpr int kCount = 3;
  static constexpr int kFraction = 0;  // bits; with none, sums are rounded to nearest
  static constexpr int kMost = 255;
};
template <int kStep>
struct Form<Luma, kStep> {
  static constexpr int kCount = 1;
  static constexpr int kFraction = kFineBits;
  static constexpr int kMost = kMostFine;
};
template <int kStep>
struct Form<Chroma, kStep> {
  static constexpr int kCount = 2;
  static constexpr int kFraction = kFineBits;
  static constexpr int kMost = kMostFine;
};

// Low and high bytes of three planes' 16 bits: as texels have them (2), or of the light of sRGB bytes (1).
template <int kStep>
struct Form<Rgb16, kStep> {
  static constexpr int kCount = 6;
  static constexpr int kFraction = 0;
  static constexpr int kMost = 65535;
};

// Channels that are the high bytes of the ones before them.
template <class F>
inline constexpr bool kDeep = F::kCount == 6;
template <class F>
CUPOLA_INLINE constexpr bool is_high(int channel) {
  return kDeep<F> && channel % 2 == 1;
}

// Where the kernel is in the table.
struct Cursor {
  const Block* block;
  const Block* last;  // of the tile, past its end
  const Window* window;
  const WeightLine* line;
  TexelsAhead* ahead;
};

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
CUPOLA_INLINE __m512i patch_index(const Window& window) {
  const __m512i four_times = _mm512_setr_epi32(
      0x00000000, 0x01010101, 0x02020202, 0x03030303, 0x04040404, 0x05050505, 0x06060606, 0x07070707,
      0x08080808, 0x09090909, 0x0a0a0a0a, 0x0b0b0b0b, 0x0c0c0c0c, 0x0d0d0d0d, 0x0e0e0e0e, 0x0f0f0f0f);
  const __m128i start = _mm_loadu_si128(reinterpret_cast<const __m128i*>(window.start.data()));
  const __m512i corner = _mm512_permutexvar_epi8(four_times, _mm512_castsi128_si512(start));
  return _mm512_add_epi8(corner, _mm512_set1_epi32(0x03020100));
}

CUPOLA_INLINE __m512i join(__m512i high, __m512i low) {
  return _mm512_add_epi32(_mm512_slli_epi32(high, 7), low);
}

// By a count a lane: shifts by one count for all need the shuffle port.
template <int kFraction>
CUPOLA_INLINE __m512i shifted(__m512i sum, const Block& block) {
  return _mm512_srav_epi32(sum, _mm512_set1_epi32(static_cast<int>(block.bits) - kFraction));
}

template <int kMost>
CUPOLA_INLINE __m512i clamped(__m512i value) {
  return _mm512_min_epi32(_mm512_max_epi32(value, _mm512_setzero_si512()), _mm512_set1_epi32(kMost));
}

// Apart, so that it takes no mask register from the loops.
[[gnu::noinline]] __m512i only_covered(__m512i pixels, std::uint16_t covered, std::uint32_t black) {
  return _mm512_mask_mov_epi32(_mm512_set1_epi32(static_cast<int>(black)), covered, pixels);
}

// Sixteen pixels of 32 bits each, 0 to Form::kMost a channel, and what is without a footprint.
CUPOLA_INLINE __m512i joined(const Channels<3>& rgb) {
  const __m512i red_green = _mm512_or_si512(_mm512_slli_epi32(rgb[0], 16), _mm512_slli_epi32(rgb[1], 8));
  __m512i black = _mm512_set1_epi32(static_cast<int>(kBlackXrgb));
  asm("" : "+v"(black));  // kept in a register
  return _mm512_ternarylogic_epi32(red_green, rgb[2], black, 0xfe);
}
CUPOLA_INLINE __m512i joined(const Channels<2>& uv) {
  return _mm512_or_si512(uv[0], _mm512_slli_epi32(uv[1], 16));
}
CUPOLA_INLINE __m512i joined(const Channels<1>& y) {
  return y[0];
}

// Pixels of 64 bits, each colour in the first of its two channels.
template <bool kAcross>
CUPOLA_INLINE void store(const Channels<6>& channels, const Block& block, const TileImage<Rgb16>& image) {
  __m512i red_green = _mm512_or_si512(channels[0], _mm512_slli_epi32(channels[2], 16));
  __m512i blue = channels[4];
  if (block.covered != kAllPixels) [[unlikely]] {
    red_green = only_covered(red_green, block.covered, 0);
    blue = only_covered(blue, block.covered, 0);
  }
  if constexpr (kAcross) {
    red_green = _mm512_shuffle_epi32(red_green, static_cast<_MM_PERM_ENUM>(0x1b));
    blue = _mm512_shuffle_epi32(blue, static_cast<_MM_PERM_ENUM>(0x1b));
  }
  const __m512i left = _mm512_unpacklo_epi32(red_green, blue);
  const __m512i right = _mm512_unpackhi_epi32(red_green, blue);
  Rgb16* out = image.corner + image.template offset<kAcross>(block.at);
  const auto put = [&](int y, __m128i first, __m128i second) {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + y * image.stride), first);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + y * image.stride + 2), second);
  };
  put(0, _mm512_castsi512_si128(left), _mm512_castsi512_si128(right));
  put(1, _mm512_extracti32x4_epi32(left, 1), _mm512_extracti32x4_epi32(right, 1));
  put(2, _mm512_extracti32x4_epi32(left, 2), _mm512_extracti32x4_epi32(right, 2));
  put(3, _mm512_extracti32x4_epi32(left, 3), _mm512_extracti32x4_epi32(right, 3));
}

// Into the block's four rows.
template <bool kAcross, class Pixel, int kCount>
CUPOLA_INLINE void store(const Channels<kCount>& channels, const Block& block,
                         const TileImage<Pixel>& image) {
  __m512i pixels = joined(channels);
  if (block.covered != kAllPixels) [[unlikely]]
    pixels = only_covered(pixels, block.covered, kCount == 3 ? kBlackXrgb : 0xffffffff);
  if constexpr (kAcross) pixels = _mm512_shuffle_epi32(pixels, static_cast<_MM_PERM_ENUM>(0x1b));
  Pixel* out = image.corner + image.template offset<kAcross>(block.at);
  const auto row = [&](int y) { return reinterpret_cast<__m128i*>(out + y * image.stride); };
  if constexpr (sizeof(Pixel) == 2) {
    const __m256i words = _mm512_cvtepi32_epi16(pixels);
    const __m128i upper = _mm256_castsi256_si128(words);
    const __m128i lower = _mm256_extracti128_si256(words, 1);
    _mm_storel_epi64(row(0), upper);
    _mm_storeh_pd(reinterpret_cast<double*>(row(1)), _mm_castsi128_pd(upper));
    _mm_storel_epi64(row(2), lower);
    _mm_storeh_pd(reinterpret_cast<double*>(row(3)), _mm_castsi128_pd(lower));
  } else {
    _mm_storeu_si128(row(0), _mm512_castsi512_si128(pixels));
    _mm_storeu_si128(row(1), _mm512_extracti32x4_epi32(pixels, 1));
    _mm_storeu_si128(row(2), _mm512_extracti32x4_epi32(pixels, 2));
    _mm_storeu_si128(row(3), _mm512_extracti32x4_epi32(pixels, 3));
  }
}

// The run_ functions go on as long as blocks are of their kind, so that constants stay in registers. They
// make kImages images of a block together; the first of them runs leftward with kAcross, a second never.

// kSigned: bytes are weights plus kBias8, whose share is summed beside and taken off again.
template <bool kSigned, bool kAcross, int kStep, int kImages, class Pixel>
void run_bytes(Cursor& at, const TileImage<Pixel>* images) {
  using F = Form<Pixel, kStep>;
  // Texels go in less 128 as the signed factor: 128 * 2^bits puts it back, 2^(bits - 1) rounds.
  static constexpr auto kStart = [] {
    std::array<std::int32_t, 16> start{};
    for (int bits = 1; bits < 16; ++bits)
      start[static_cast<std::size_t>(bits)] = ((F::kFraction == 0 ? 257 : 256) << bits) >> 1;
    return start;
  }();
  const __m512i sign = _mm512_set1_epi8(static_cast<char>(0x80));
  const __m512i bias = _mm512_set1_epi8(kBias8);
  const __m512i next_row = _mm512_set1_epi8(kWindowSide);
  const WindowLoad<F::kCount, kStep> load;
  const Block* block = at.block;
  const Window* window = at.window;
  const WeightLine* line = at.line;
  do {
    if constexpr (F::kCount != 3) at.ahead->step();
    const __m512i start = _mm512_set1_epi32(kStart[block->bits]);
    const __m512i unrounded = _mm512_set1_epi32(128 << block->bits);
    Channels<F::kCount> sum[kImages];
    Channels<F::kCount> biased[kImages]{};
    for (int i = 0; i < kImages; ++i) {
      for (int channel = 0; channel < F::kCount; ++channel)
        sum[i][channel] = is_high<F>(channel) ? unrounded : start;
    }
    for (const Window* end = window + block->window_count; window != end; ++window) {
      Texels<kImages, F::kCount> texels = load_windows<kImages>(images, *window, load);
      __m512i index[kImages];
      for (int i = 0; i < kImages; ++i) {
        for (int channel = 0; channel < F::kCount; ++channel)
          texels.of[i][channel] = _mm512_xor_si512(texels.of[i][channel], sign);
        index[i] = _mm512_xor_si512(patch_index(*window), flip_of(images[i].views[window->view]));
      }
      repeat_rows(window->rows, [&]() CUPOLA_INLINE_LAMBDA {
        const __m512i weights = next_line(line);
        for (int i = 0; i < kImages; ++i) {
          for (int channel = 0; channel < F::kCount; ++channel) {
            const __m512i patch = _mm512_permutexvar_epi8(index[i], texels.of[i][channel]);
            sum[i][channel] = _mm512_dpbusd_epi32(sum[i][channel], weights, patch);
            if constexpr (kSigned) biased[i][channel] = _mm512_dpbusd_epi32(biased[i][channel], bias, patch);
          }
          index[i] = _mm512_add_epi8(index[i], next_row);
        }
      });
    }
    for (int i = 0; i < kImages; ++i) {
      for (int channel = 0; channel < F::kCount; ++channel) {
        if constexpr (kSigned) {
          sum[i][channel] = _mm512_sub_epi32(sum[i][channel], biased[i][channel]);
        }
      }
      // 256 times the sum of high bytes is below 2^29: weights of bytes sum to at most 3 * 2^9.
      for (int channel = 0; channel < F::kCount; channel += kDeep<F> ? 2 : 1) {
        if constexpr (kDeep<F>) {
          const __m512i high = _mm512_slli_epi32(sum[i][channel + 1], 8);
          sum[i][channel] = _mm512_add_epi32(sum[i][channel], high);
        }
        sum[i][channel] = shifted<F::kFraction>(sum[i][channel], *block);
        if constexpr (kSigned) sum[i][channel] = clamped<F::kMost>(sum[i][channel]);
      }
    }
    store<kAcross>(sum[0], *block, images[0]);
    if constexpr (kImages == 2) store<false>(sum[1], *block, images[1]);
    ++block;
  } while (block != at.last && block->kind == (kSigned ? BlockKind::kSigned8 : BlockKind::kNarrow8));
  at = {block, at.last, window, line, at.ahead};
}

template <class F>
CUPOLA_INLINE Channels<F::kCount> finish16(const Channels<F::kCount>& high, const Channels<F::kCount>& low,
                                           const Block& block) {
  Channels<F::kCount> channels;
  const __m512i one = _mm512_set1_epi32(F::kFraction == 0 ? 1 : 0);
  const __m512i half = _mm512_sllv_epi32(one, _mm512_set1_epi32(static_cast<int>(block.bits - 1)));
  for (int channel = 0; channel < F::kCount; channel += kDeep<F> ? 2 : 1) {
    const __m512i sum = _mm512_add_epi32(join(high[channel], low[channel]), half);
    if constexpr (kDeep<F>) {
      // 256 times the sum of high bytes may not fit. Floors nest, and bits >= 12: so the sum of low bytes may
      // lose its last 8 bits before the two are added.
      const __m512i upper = join(high[channel + 1], low[channel + 1]);
      const __m512i both = _mm512_add_epi32(upper, _mm512_srai_epi32(sum, 8));
      channels[channel] = clamped<F::kMost>(shifted<8>(both, block));
    } else {
      channels[channel] = clamped<F::kMost>(shifted<F::kFraction>(sum, block));
    }
  }
  return channels;
}

template <bool kAcross, int kStep, int kImages, class Pixel>
void run_pairs(Cursor& at, const TileImage<Pixel>* images) {
  using F = Form<Pixel, kStep>;
  const __m512i next_row = _mm512_set1_epi8(kWindowSide);
  const WindowLoad<F::kCount, kStep> load;
  const Block* block = at.block;
  const Window* window = at.window;
  const WeightLine* line = at.line;
  do {
    if constexpr (F::kCount != 3) at.ahead->step();
    Channels<F::kCount> high[kImages]{};
    Channels<F::kCount> low[kImages]{};
    for (const Window* end = window + block->window_count; window != end; ++window) {
      const Texels<kImages, F::kCount> texels = load_windows<kImages>(images, *window, load);
      __m512i index[kImages];
      for (int i = 0; i < kImages; ++i)
        index[i] = _mm512_xor_si512(patch_index(*window), flip_of(images[i].views[window->view]));
      repeat_rows(window->rows, [&]() CUPOLA_INLINE_LAMBDA {
        const __m512i weights_high = next_line(line);
        const __m512i weights_low = next_line(line);
        for (int i = 0; i < kImages; ++i) {
          for (int channel = 0; channel < F::kCount; ++channel) {
            const __m512i patch = _mm512_permutexvar_epi8(index[i], texels.of[i][channel]);
            high[i][channel] = _mm512_dpbusd_epi32(high[i][channel], patch, weights_high);
            low[i][channel] = _mm512_dpbusd_epi32(low[i][channel], patch, weights_low);
          }
          index[i] = _mm512_add_epi8(index[i], next_row);
        }
      });
    }
    store<kAcross>(finish16<F>(high[0], low[0], *block), *block, images[0]);
    if constexpr (kImages == 2) store<false>(finish16<F>(high[1], low[1], *block), *block, images[1]);
    ++block;
  } while (block != at.last && block->kind == BlockKind::kNarrow16);
  at = {block, at.last, window, line, at.ahead};
}

// One block of one image: its windows are many.
template <bool kAcross, int kStep, class Pixel>
void run_wide(Cursor& at, const TileImage<Pixel>& image) {
  using F = Form<Pixel, kStep>;
  const __m512i in_order =
      _mm512_set_epi64(0x3f3e3d3c3b3a3938, 0x3736353433323130, 0x2f2e2d2c2b2a2928, 0x2726252423222120,
                       0x1f1e1d1c1b1a1918, 0x1716151413121110, 0x0f0e0d0c0b0a0908, 0x0706050403020100);
  const WindowLoad<F::kCount, kStep> load;
  alignas(64) std::array<std::array<std::int32_t, kPixelsInBlock>, F::kCount> sums{};
  const WeightLine* line = at.line;
  const Window* window = at.window;
  for (const Window* end = window + at.block->window_count; window != end;) {
    const int pixel = window->start[0];
    Channels<F::kCount> high{};
    Channels<F::kCount> low{};
    for (; window != end && window->start[0] == pixel; ++window, line += 2) {
      const ViewTexels& view = image.views[window->view];
      const Channels<F::kCount> texels = load_windows<1>(&image, *window, load).of[0];
      const __m512i turned = _mm512_xor_si512(in_order, flip_of(view));
      const __m512i weights_high = _mm512_permutexvar_epi8(turned, _mm512_load_si512(line));
      const __m512i weights_low = _mm512_permutexvar_epi8(turned, _mm512_load_si512(line + 1));
      for (int channel = 0; channel < F::kCount; ++channel) {
        high[channel] = _mm512_dpbusd_epi32(high[channel], texels[channel], weights_high);
        low[channel] = _mm512_dpbusd_epi32(low[channel], texels[channel], weights_low);
      }
    }
    for (int channel = 0; channel < F::kCount; ++channel) {
      sums[channel][pixel] = _mm512_reduce_add_epi32(join(high[channel], low[channel]));
    }
  }
  Channels<F::kCount> total;
  for (int channel = 0; channel < F::kCount; ++channel)
    total[channel] = _mm512_load_si512(sums[channel].data());
  store<kAcross>(finish16<F>({}, total, *at.block), *at.block, image);
  at = {at.block + 1, at.last, window, line, at.ahead};
}

template <bool kAcross, int kStep, int kImages, class Pixel>
void run_image(const WarpTable& table, const Tile& tile, const TileImage<Pixel>* images) {
  const Block* first = table.blocks.data() + tile.first_block;
  Cursor at{first, first + tile.block_count, table.windows.data() + tile.first_window,
            table.lines.data() + tile.first_line, nullptr};
  TexelsAhead ahead;
  if constexpr (constexpr int kCount = Form<Pixel, kStep>::kCount; kCount != 3) {
    constexpr int kPlanes = kCount == 6 ? 3 : kStep == 1 ? kCount : 1;
    if (&tile != &table.tiles.back())
      ahead = {table, *(&tile + 1), images, kImages, kPlanes, tile.block_count};
    at.ahead = &ahead;
  }
  while (at.block != at.last) {
    switch (at.block->kind) {
      case BlockKind::kNarrow8:
        run_bytes<false, kAcross, kStep, kImages>(at, images);
        break;
      case BlockKind::kSigned8:
        run_bytes<true, kAcross, kStep, kImages>(at, images);
        break;
      case BlockKind::kNarrow16:
        run_pairs<kAcross, kStep, kImages>(at, images);
        break;
      case BlockKind::kWide16: {
        const Cursor here = at;
        run_wide<kAcross, kStep>(at, images[0]);
        if constexpr (kImages == 2) {
          at = here;
          run_wide<false, kStep>(at, images[1]);
        }
        break;
      }
    }
  }
}

template <int kStep, int kImages, class Pixel>
void run_either_way(const WarpTable& table, const Tile& tile, const TileImage<Pixel>* images) {
  if (images->across) {
    run_image<true, kStep, kImages>(table, tile, images);
  } else {
    run_image<false, kStep, kImages>(table, tile, images);
  }
}

// Three channels keep the processor busy by themselves; with fewer, two images share what reading the table
// costs.
template <int kStep, class Pixel>
void run_images(const WarpTable& table, const Tile& tile, std::span<const TileImage<Pixel>> images) {
  while (!images.empty()) {
    if constexpr (Form<Pixel, kStep>::kCount < 3) {
      if (images.size() > 1 && !images[1].across) {
        run_either_way<kStep, 2>(table, tile, images.data());
        images = images.subspan(2);
        continue;
      }
    }
    run_either_way<kStep, 1>(table, tile, images.data());
    images = images.subspan(1);
  }
}

}  // namespace

void run_tile_avx512(const WarpTable& table, const Tile& tile,
                     std::span<const TileImage<Xrgb>> images) noexcept {
  run_images<1>(table, tile, images);
}

void run_rgb3_avx512(const WarpTable& table, const Tile& tile,
                     std::span<const TileImage<Xrgb>> images) noexcept {
  run_images<3>(table, tile, images);
}

void run_rgb4_avx512(const WarpTable& table, const Tile& tile,
                     std::span<const TileImage<Xrgb>> images) noexcept {
  run_images<4>(table, tile, images);
}

void run_wide_avx512(const WarpTable& table, const Tile& tile,
                     std::span<const TileImage<Rgb16>> images) noexcept {
  run_images<2>(table, tile, images);
}

void run_linear_avx512(const WarpTable& table, const Tile& tile,
                       std::span<const TileImage<Rgb16>> images) noexcept {
  run_images<1>(table, tile, images);
}

void run_luma1_avx512(const WarpTable& table, const Tile& tile,
                      std::span<const TileImage<Luma>> images) noexcept {
  run_images<1>(table, tile, images);
}

void run_luma2_avx512(const WarpTable& table, const Tile& tile,
                      std::span<const TileImage<Luma>> images) noexcept {
  run_images<2>(table, tile, images);
}

void run_chroma1_avx512(const WarpTable& table, const Tile& tile,
                        std::span<const TileImage<Chroma>> images) noexcept {
  run_images<1>(table, tile, images);
}

void run_chroma2_avx512(const WarpTable& table, const Tile& tile,
                        std::span<const TileImage<Chroma>> images) noexcept {
  run_images<2>(table, tile, images);
}

void run_chroma4_avx512(const WarpTable& table, const Tile& tile,
                        std::span<const TileImage<Chroma>> images) noexcept {
  run_images<4>(table, tile, images);
}

}  // namespace cupola
