// The warp with NEON (AArch64): a window of 8 x 8 texels is four registers, and one table look-up gives four
// pixels their patch row.
// SPDX-License-Identifier: MIT
#include <arm_neon.h>

#include "pipeline/warp/tile_kernel.h"

namespace cupola {
namespace {

constexpr int kParts = kPixelsInBlock / 4;  // registers of 32 bits a pixel a block

// 32 bits a pixel, for one channel.
struct Sums {
  int32x4_t of[kParts];
};
struct Channels {
  Sums of[3];
};

// What a block's sum reads.
struct Source {
  const Block& block;
  const Window* window;
  const WeightLine* line;
  const ViewTexels* views;
};

CUPOLA_INLINE uint8x16_t load_two_rows(const std::uint8_t* row, std::ptrdiff_t stride) {
  return vcombine_u8(vld1_u8(row), vld1_u8(row + stride));
}

// The first `used` rows of a window, some more perhaps; rows that are not are repeats of the first.
CUPOLA_INLINE uint8x16x4_t load_window(const std::uint8_t* texels, std::ptrdiff_t stride, int used) {
  const uint8x16_t first = load_two_rows(texels, stride);
  uint8x16x4_t window = {{first, first, first, first}};
  if (used > 2) window.val[1] = load_two_rows(texels + 2 * stride, stride);
  if (used > 4) window.val[2] = load_two_rows(texels + 4 * stride, stride);
  if (used > 6) window.val[3] = load_two_rows(texels + 6 * stride, stride);
  return window;
}

struct PatchIndex {
  uint8x16_t of[kParts];
};

// Where in the window each pixel's first patch row lies: 4 bytes a pixel.
CUPOLA_INLINE PatchIndex patch_index(const Window& window, std::uint32_t flip) {
  const uint8x16_t start = vld1q_u8(window.start.data());
  const uint8x16_t along = vreinterpretq_u8_u32(vdupq_n_u32(0x03020100));
  const uint8x16_t turned = vreinterpretq_u8_u32(vdupq_n_u32(flip));
  const uint8x16_t twice_low = vzip1q_u8(start, start);
  const uint8x16_t twice_high = vzip2q_u8(start, start);
  const uint8x16_t four_times[kParts] = {vzip1q_u8(twice_low, twice_low), vzip2q_u8(twice_low, twice_low),
                                         vzip1q_u8(twice_high, twice_high),
                                         vzip2q_u8(twice_high, twice_high)};
  PatchIndex index;
  for (int part = 0; part < kParts; ++part) {
    index.of[part] = veorq_u8(vaddq_u8(four_times[part], along), turned);
  }
  return index;
}

// Unsigned texels times unsigned bytes: four products a pixel, each below 2^16, two of them below 2^17:
// summed in pairs to 32 bits, then pairs of those.
CUPOLA_INLINE int32x4_t sum_unsigned(uint8x16_t texels, uint8x16_t weights) {
  const uint32x4_t first = vpaddlq_u16(vmull_u8(vget_low_u8(texels), vget_low_u8(weights)));
  const uint32x4_t second = vpaddlq_u16(vmull_high_u8(texels, weights));
  return vreinterpretq_s32_u32(vpaddq_u32(first, second));
}

// Unsigned texels times signed bytes of -64 to 64: products within 16,320, two of them within 16 bits.
CUPOLA_INLINE int32x4_t sum_signed(uint8x16_t texels, int8x16_t weights) {
  const int16x8_t first =
      vmulq_s16(vreinterpretq_s16_u16(vmovl_u8(vget_low_u8(texels))), vmovl_s8(vget_low_s8(weights)));
  const int16x8_t second = vmulq_s16(vreinterpretq_s16_u16(vmovl_high_u8(texels)), vmovl_high_s8(weights));
  return vpaddlq_s16(vpaddq_s16(first, second));
}

// The bias' share: kBias8 times a pixel's four texels.
CUPOLA_INLINE int32x4_t sum_biased(uint8x16_t texels) {
  static_assert(kBias8 == 1 << 5);
  return vreinterpretq_s32_u32(vshlq_n_u32(vpaddlq_u16(vpaddlq_u8(texels)), 5));
}

CUPOLA_INLINE int32x4_t weighed128(int32x4_t high, int32x4_t low) {
  return vaddq_s32(vshlq_n_s32(high, 7), low);
}

template <BlockKind kKind>
CUPOLA_INLINE int32x4_t product(uint8x16_t texels, const WeightLine* line, int part) {
  const uint8x16_t first = vld1q_u8(line[0].bytes.data() + part * 16);
  if constexpr (kKind == BlockKind::kNarrow8) {
    return sum_unsigned(texels, first);
  } else if constexpr (kKind == BlockKind::kSigned8) {
    return vsubq_s32(sum_unsigned(texels, first), sum_biased(texels));
  } else {
    const uint8x16_t second = vld1q_u8(line[1].bytes.data() + part * 16);
    return weighed128(sum_signed(texels, vreinterpretq_s8_u8(first)),
                      sum_signed(texels, vreinterpretq_s8_u8(second)));
  }
}

CUPOLA_INLINE void round_to_bytes(Channels& sums, int bits) {
  const int32x4_t right = vdupq_n_s32(-bits);
  for (Sums& channel : sums.of) {
    for (int32x4_t& sum : channel.of) {
      sum = vminq_s32(vmaxq_s32(vrshlq_s32(sum, right), vdupq_n_s32(0)), vdupq_n_s32(255));
    }
  }
}

template <BlockKind kKind>
CUPOLA_INLINE Channels sum_narrow(const Source& from) {
  constexpr int kLinesARow = kKind == BlockKind::kNarrow16 ? 2 : 1;
  const uint8x16_t next_row = vdupq_n_u8(kWindowSide);
  Channels sums{};
  const WeightLine* line = from.line;
  const Window* window = from.window;
  for (const Window* end = window + from.block.window_count; window != end; ++window) {
    const ViewTexels& view = from.views[window->view];
    uint8x16x4_t texels[3];
    for (int channel = 0; channel < 3; ++channel) {
      texels[channel] = load_window(view.window(channel, window->x, window->y), view.stride, window->used);
    }
    PatchIndex index = patch_index(*window, view.flip);
    for (const WeightLine* last = line + kLinesARow * window->rows; line != last; line += kLinesARow) {
      for (int part = 0; part < kParts; ++part) {
        for (int channel = 0; channel < 3; ++channel) {
          const uint8x16_t patch = vqtbl4q_u8(texels[channel], index.of[part]);
          int32x4_t& sum = sums.of[channel].of[part];
          sum = vaddq_s32(sum, product<kKind>(patch, line, part));
        }
        index.of[part] = vaddq_u8(index.of[part], next_row);
      }
      prefetch_after(line);
    }
  }
  round_to_bytes(sums, from.block.bits);
  return sums;
}

Channels sum_wide(const Source& from) {
  std::array<std::array<std::int32_t, kPixelsInBlock>, 3> totals{};
  const WeightLine* line = from.line;
  const Window* window = from.window;
  for (const Window* end = window + from.block.window_count; window != end; ++window, line += 2) {
    const ViewTexels& view = from.views[window->view];
    const uint8x16_t in_order = vcombine_u8(vcreate_u8(0x0706050403020100), vcreate_u8(0x0f0e0d0c0b0a0908));
    const uint8x16_t turned = veorq_u8(in_order, vreinterpretq_u8_u32(vdupq_n_u32(view.flip)));
    for (int channel = 0; channel < 3; ++channel) {
      const std::uint8_t* row = view.window(channel, window->x, window->y);
      const std::ptrdiff_t stride = view.stride;
      int32x4_t sum = vdupq_n_s32(0);
      for (int two = 0; two < kWindowSide / 2; ++two, row += 2 * stride) {
        const uint8x16_t texels = vqtbl1q_u8(load_two_rows(row, stride), turned);
        sum = vaddq_s32(sum, product<BlockKind::kWide16>(texels, line, two));
      }
      totals[channel][window->start[0]] += vaddvq_s32(sum);
    }
  }
  Channels sums;
  for (int channel = 0; channel < 3; ++channel) {
    for (int part = 0; part < kParts; ++part) {
      sums.of[channel].of[part] = vld1q_s32(totals[channel].data() + part * 4);
    }
  }
  round_to_bytes(sums, from.block.bits);
  return sums;
}

CUPOLA_INLINE Channels sum_block(const Source& from) {
  switch (from.block.kind) {
    case BlockKind::kNarrow8:
      return sum_narrow<BlockKind::kNarrow8>(from);
    case BlockKind::kSigned8:
      return sum_narrow<BlockKind::kSigned8>(from);
    case BlockKind::kNarrow16:
      return sum_narrow<BlockKind::kNarrow16>(from);
    case BlockKind::kWide16:
      break;
  }
  return sum_wide(from);
}

// Sixteen pixels, each 0 to 255 a channel, into the block's four rows.
CUPOLA_INLINE void store(const Channels& rgb, const Block& block, const TileImage<Xrgb>& image) {
  const uint32x4_t black = vdupq_n_u32(kBlackXrgb);
  Xrgb* out = image.block(block.at);
  for (int part = 0; part < kParts; ++part, out += image.stride) {
    const auto channel = [&](int c) { return vreinterpretq_u32_s32(rgb.of[c].of[part]); };
    uint32x4_t pixels = vsliq_n_u32(vsliq_n_u32(channel(2), channel(1), 8), channel(0), 16);
    if (block.covered != kAllPixels) {
      const std::uint32_t bits = static_cast<std::uint32_t>(block.covered) >> part * 4;
      const uint32x4_t bit = {1, 2, 4, 8};
      pixels = vandq_u32(pixels, vtstq_u32(vdupq_n_u32(bits), bit));
    }
    pixels = vorrq_u32(pixels, black);
    if (image.across) {
      pixels = vrev64q_u32(pixels);
      pixels = vextq_u32(pixels, pixels, 2);
    }
    vst1q_u32(out, pixels);
  }
}

}  // namespace

void run_tile_neon(const WarpTable& table, const Tile& tile,
                   std::span<const TileImage<Xrgb>> images) noexcept {
  for (const TileImage<Xrgb>& image : images) {
    const Block* block = table.blocks.data() + tile.first_block;
    const Window* window = table.windows.data() + tile.first_window;
    const WeightLine* line = table.lines.data() + tile.first_line;
    for (const Block* end = block + tile.block_count; block != end; ++block) {
      store(sum_block({*block, window, line, image.views.data()}), *block, image);
      window += block->window_count;
      line += block->line_count;
    }
  }
}

}  // namespace cupola
