// The warp with registers of 16 bytes, or several of them side by side: two rows of a window fill one, and a
// byte shuffle gives four pixels their patch row. A template over the register, for SSE4.1, which is NEON on
// AArch64 (sse4.h), and AVX2, and over what goes in and comes out (paired_texels.h).
//
// A group is a block's row of four pixels. Row pair r is the window's rows r and r + 1; all pairs of a window
// are made once, in the cache, so that a group finds the texels of its k-th patch row by one load, at pair k
// from its highest start. Where the starts of a group lie further apart than a row, pairs 2, 4 and 6 further
// down are shuffled too. Where sums fit the registers two mirror images of a block are made at once: what is
// read of the table, and what follows from it, is the same but for the columns' order.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/warp/paired_texels.h"
#include "pipeline/warp/sse4.h"
#include "pipeline/warp/tile_kernel.h"

namespace cupola {

// `Lanes` is of the including file alone, and with it all that comes of this template: code for one
// instruction set is never taken for another's.
template <class Lanes, class Pixel, int kStep>
class PairKernel {
 public:
  static void run(const WarpTable& table, const Tile& tile,
                  std::span<const TileImage<Pixel>> images) noexcept {
    PairKernel kernel;
    if constexpr (kAtOnce == 2) {
      for (; images.size() >= 2; images = images.subspan(2)) {
        kernel.template run_images<2>(table, tile, images.template first<2>());
      }
    }
    for (; !images.empty(); images = images.subspan(1)) {
      kernel.template run_images<1>(table, tile, images.template first<1>());
    }
  }

 private:
  using In = PairedTexels<Lanes, Pixel, kStep>;
  static constexpr bool kDeep = std::is_same_v<Pixel, Rgb16> || kStep == kOf16Bits;  // samples of 16 bits
  static constexpr bool kFine = std::is_same_v<Pixel, Luma> || std::is_same_v<Pixel, Chroma>;
  static constexpr int kFraction = kFine ? kFineBits : 0;         // bits that sums keep
  static constexpr int kChannels = In::kSources * In::kOfSource;  // of bytes
  using Register = typename Lanes::Register;
  static constexpr int kParts = kBlockSide / Lanes::kGroups;  // registers of 32 bits a pixel a block
  static constexpr int kPartBytes = Lanes::kGroups * 16;
  static constexpr int kAtOnce =
      2 * kChannels * kParts <= 8 ? 2 : 1;  // images: sums in half of the registers

  template <int kImages>
  using Images = std::span<const TileImage<Pixel>, kImages>;

  // What a block's sum reads.
  struct Source {
    const Block& block;
    const Window* window;
    const WeightLine* line;
  };

  // 32 bits a pixel.
  struct Sums {
    Register of[kChannels][kParts];
  };

  // Where the groups of a window look: byte offsets of each one's first row pair, and bytes to pick from it.
  template <int kImages, int kReach>
  struct Places {
    std::size_t pair[kBlockSide];
    Register index[kImages][kReach][kParts];
  };

  // Row pairs 0 to 2 kTwos - 1; texels less 128 if kSigned. The last pair's second row is of no use to
  // anyone.
  template <bool kSigned, int kTwos>
  CUPOLA_INLINE void make_pairs(int image, const ViewTexels& view, const Window& window) {
    const auto put_pair = [&](int channel, int row, __m128i pair) {
      _mm_store_si128(reinterpret_cast<__m128i*>(pairs_[image][channel][row]), pair);
    };
    const __m128i sign = _mm_set1_epi8(static_cast<char>(kSigned ? 0x80 : 0));
    constexpr int kOf = In::kOfSource;
    for (int source = 0; source < In::kSources; ++source) {
      const std::uint8_t* row = In::first(view, source, window.x, window.y);
      const std::ptrdiff_t stride = view.stride;
      const int channel = source * kOf;
      TwoRows<kOf> above = In::two_rows(view, row, stride);
      for (int i = 0; i < kOf; ++i) {
        above.of[i] = _mm_xor_si128(above.of[i], sign);
        put_pair(channel + i, 0, above.of[i]);
      }
      for (int two = 1; two < kTwos; ++two) {
        row += 2 * stride;
        TwoRows<kOf> below = In::two_rows(view, row, stride);
        for (int i = 0; i < kOf; ++i) {
          below.of[i] = _mm_xor_si128(below.of[i], sign);
          put_pair(channel + i, 2 * two - 1, _mm_alignr_epi8(below.of[i], above.of[i], 8));
          put_pair(channel + i, 2 * two, below.of[i]);
        }
        above = below;
      }
      for (int i = 0; i < kOf; ++i)
        put_pair(channel + i, 2 * kTwos - 1, _mm_unpackhi_epi64(above.of[i], above.of[i]));
    }
  }

  template <bool kSigned, int kTwos, int kImages>
  CUPOLA_INLINE void make_pairs(const Images<kImages>& images, const Window& window) {
    for (int i = 0; i < kImages; ++i) make_pairs<kSigned, kTwos>(i, images[i].views[window.view], window);
  }

  template <bool kSigned, int kImages>
  CUPOLA_INLINE void make_pairs(const Images<kImages>& images, const Window& window) {
    if (window.used > 6) {
      make_pairs<kSigned, 4, kImages>(images, window);
    } else if (window.used > 4) {
      make_pairs<kSigned, 3, kImages>(images, window);
    } else if (window.used > 2) {
      make_pairs<kSigned, 2, kImages>(images, window);
    } else {
      make_pairs<kSigned, 1, kImages>(images, window);
    }
  }

  template <int kImages, int kReach>
  CUPOLA_INLINE static Places<kImages, kReach> places(const Images<kImages>& images, const Window& window) {
    const __m128i start = _mm_loadu_si128(reinterpret_cast<const __m128i*>(window.start.data()));
    // 8 * row, and the least of a group's in each fourth byte.
    __m128i least = _mm_and_si128(start, _mm_set1_epi8(0x38));
    least = _mm_min_epu8(least, _mm_srli_epi32(least, 16));
    least = _mm_min_epu8(least, _mm_srli_epi32(least, 8));
    const __m128i all_four = _mm_setr_epi8(0, 0, 0, 0, 4, 4, 4, 4, 8, 8, 8, 8, 12, 12, 12, 12);
    const __m128i within = _mm_sub_epi8(start, _mm_shuffle_epi8(least, all_four));  // 0..8 * spread + 4

    Places<kImages, kReach> places;
    alignas(16) std::uint8_t eight_rows[16];  // cheaper than four extractions
    _mm_store_si128(reinterpret_cast<__m128i*>(eight_rows), least);
    for (std::size_t g = 0; g < kBlockSide; ++g) places.pair[g] = std::size_t{eight_rows[4 * g]} * 2;
    for (int part = 0; part < kParts; ++part) {
      const Register four_times =
          Lanes::shuffle(Lanes::all(within), Lanes::load(kFourTimes.data() + part * kPartBytes));
      const Register straight = Lanes::add8(four_times, Lanes::all32(0x03020100));
      for (int image = 0; image < kImages; ++image) {
        const auto flip = static_cast<int>(images[image].views[window.view].flip);
        const Register at = Lanes::exclusive_or(straight, Lanes::all32(flip));
        if constexpr (kReach == 1) {
          places.index[image][0][part] = at;
        } else {
          // A shuffle makes bytes zero whose index has bit 7: here all that are not 16 i to 16 i + 15.
          for (int i = 0; i < kReach; ++i) {
            places.index[image][i][part] =
                Lanes::add8_saturated(Lanes::sub8(at, Lanes::all8(16 * i)), Lanes::all8(0x70));
          }
        }
      }
    }
    return places;
  }

  // The patch row of the pixels of one part, 4 bytes each; `pair` is the first group's first row pair, or as
  // many further as patch rows went before.
  template <int kImages, int kReach>
  CUPOLA_INLINE static Register patch(const std::uint8_t* pairs, const Places<kImages, kReach>& places,
                                      int image, int part) {
    const std::size_t* offset = places.pair + part * Lanes::kGroups;
    Register patch = Lanes::shuffle(Lanes::gather(pairs, offset), places.index[image][0][part]);
    for (int i = 1; i < kReach; ++i) {
      const Register further = Lanes::gather(pairs + 2 * i * kPairBytes, offset);
      patch = Lanes::either(patch, Lanes::shuffle(further, places.index[image][i][part]));
    }
    return patch;
  }

  struct Weights {
    Register first;
    Register second;  // kNarrow16: the low bytes
  };

  // Products of a pixel's four texels and weights, summed: 16 bits for two of them, exact as warp_table.h
  // says, then 32.
  template <BlockKind kKind>
  CUPOLA_INLINE static Register product(Register patch, const Weights& weights) {
    if constexpr (kKind == BlockKind::kNarrow8) {
      return Lanes::sum_two(Lanes::multiply(weights.first, patch), Lanes::all16(1));
    } else if constexpr (kKind == BlockKind::kSigned8) {
      // The difference is in range too: two weights that are -32 to 223 less the bias are at most 255
      // together in magnitude, times 128.
      const Register biased = Lanes::multiply(Lanes::all8(kBias8), patch);
      return Lanes::sum_two(Lanes::sub16(Lanes::multiply(weights.first, patch), biased), Lanes::all16(1));
    } else {
      // 128 * high may wrap; with low added in the end, the total fits again.
      return Lanes::add32(Lanes::sum_two(Lanes::multiply(patch, weights.first), Lanes::all16(128)),
                          Lanes::sum_two(Lanes::multiply(patch, weights.second), Lanes::all16(1)));
    }
  }

  template <BlockKind kKind, int kReach, int kImages>
  CUPOLA_INLINE const WeightLine* add_patches(Sums (&sums)[kImages], const Images<kImages>& images,
                                              const Window& window, const WeightLine* line) const {
    constexpr int kLinesARow = kKind == BlockKind::kNarrow16 ? 2 : 1;
    const Places<kImages, kReach> here = places<kImages, kReach>(images, window);
    const std::uint8_t* pairs = pairs_[0][0][0];
    for (const WeightLine* end = line + kLinesARow * window.rows; line != end; line += kLinesARow) {
      for (int part = 0; part < kParts; ++part) {
        Weights weights;
        weights.first = Lanes::load(line[0].bytes.data() + part * kPartBytes);
        if constexpr (kLinesARow == 2) weights.second = Lanes::load(line[1].bytes.data() + part * kPartBytes);
        for (int image = 0; image < kImages; ++image) {
          for (int channel = 0; channel < kChannels; ++channel) {
            const std::uint8_t* of = pairs + (image * kChannels + channel) * kChannelBytes;
            Register& sum = sums[image].of[channel][part];
            sum = Lanes::add32(sum, product<kKind>(patch(of, here, image, part), weights));
          }
        }
      }
      pairs += kPairBytes;
      prefetch_after(line);
    }
    return line;
  }

  template <BlockKind kKind, int kImages>
  CUPOLA_INLINE void sum_narrow(const Source& from, const Images<kImages>& images, Sums (&sums)[kImages]) {
    constexpr bool kSigned = kKind != BlockKind::kNarrow16;  // texels are
    const int bits = from.block.bits;
    // Puts 128 * 2^bits back, and rounds what is not rounded later.
    const Register unrounded = Lanes::all32(kSigned ? 128 << bits : 0);
    const Register start = kFine ? unrounded : Lanes::all32(kSigned ? (257 << bits) >> 1 : 1 << (bits - 1));
    for (Sums& of_image : sums) {
      for (int channel = 0; channel < kChannels; ++channel) {
        for (Register& sum : of_image.of[channel]) sum = kDeep && channel % 2 == 1 ? unrounded : start;
      }
    }
    const WeightLine* line = from.line;
    const Window* window = from.window;
    for (const Window* end = window + from.block.window_count; window != end; ++window) {
      make_pairs<kSigned, kImages>(images, *window);
      if (window->spread <= 1) {
        line = add_patches<kKind, 1, kImages>(sums, images, *window, line);
      } else if (window->spread <= 3) {
        line = add_patches<kKind, 2, kImages>(sums, images, *window, line);
      } else {
        line = add_patches<kKind, 4, kImages>(sums, images, *window, line);
      }
    }
    for (Sums& of_image : sums) finish<kKind>(of_image, bits);
  }

  // From sums to samples; of 16-bit texels, whose low and high bytes were summed apart, into the first of
  // both channels. There 256 high + low is below 2^29 for weights of bytes. For those of 16 bits it may not
  // fit, but since floors nest and bits >= 12 the low sum may first lose its last 8 bits.
  template <BlockKind kKind>
  CUPOLA_INLINE static void finish(Sums& sums, int bits) {
    constexpr bool kBytes = kKind == BlockKind::kNarrow8 || kKind == BlockKind::kSigned8;
    constexpr int kMost = kFine ? (kDeep ? kMostWideFine : kMostFine) : kDeep ? 65535 : 255;
    constexpr int kSteps = kDeep && kFine ? 8 : 0;  // bits of a sample's steps below those of 8 bits
    for (int channel = 0; channel < kChannels; channel += kDeep ? 2 : 1) {
      for (int part = 0; part < kParts; ++part) {
        Register sum = sums.of[channel][part];
        if constexpr (!kDeep) {
          sum = Lanes::shift_right(sum, bits - kFraction);
        } else if constexpr (kBytes) {
          const Register high = Lanes::template shift_left<8>(sums.of[channel + 1][part]);
          sum = Lanes::shift_right(Lanes::add32(high, sum), bits + kSteps - kFraction);
        } else {
          sum = Lanes::shift_right(Lanes::add32(sums.of[channel + 1][part], Lanes::shift_right(sum, 8)),
                                   bits - 8 + kSteps - kFraction);
        }
        if constexpr (kKind != BlockKind::kNarrow8) sum = Lanes::template clamp<kMost>(sum);
        sums.of[channel][part] = sum;
      }
    }
  }

  // Two rows of texels by two of high and of low weights, into four sums.
  CUPOLA_INLINE static __m128i wide_product(__m128i texels, const WeightLine* line, int two) {
    const auto* high = reinterpret_cast<const __m128i*>(line[0].bytes.data()) + two;
    const auto* low = reinterpret_cast<const __m128i*>(line[1].bytes.data()) + two;
    return _mm_add_epi32(_mm_madd_epi16(_mm_maddubs_epi16(texels, _mm_load_si128(high)), _mm_set1_epi16(128)),
                         _mm_madd_epi16(_mm_maddubs_epi16(texels, _mm_load_si128(low)), _mm_set1_epi16(1)));
  }

  // Rare, and 16 bytes wide for every instruction set.
  [[gnu::noinline]] static Sums sum_wide(const Source& from, const ViewTexels* views) {
    alignas(64) std::array<std::array<std::int32_t, kPixelsInBlock>, kChannels> totals{};
    const WeightLine* line = from.line;
    const Window* window = from.window;
    for (const Window* end = window + from.block.window_count; window != end; ++window, line += 2) {
      const ViewTexels& view = views[window->view];
      const __m128i turned = _mm_xor_si128(_mm_set_epi64x(0x0f0e0d0c0b0a0908, 0x0706050403020100),
                                           _mm_set1_epi32(static_cast<int>(view.flip)));
      for (int source = 0; source < In::kSources; ++source) {
        const std::uint8_t* row = In::first(view, source, window->x, window->y);
        const std::ptrdiff_t stride = view.stride;
        __m128i sums[In::kOfSource] = {};
        for (int two = 0; two < kWindowSide / 2; ++two, row += 2 * stride) {
          const TwoRows<In::kOfSource> texels = In::two_rows(view, row, stride);
          for (int i = 0; i < In::kOfSource; ++i) {
            sums[i] = _mm_add_epi32(sums[i], wide_product(_mm_shuffle_epi8(texels.of[i], turned), line, two));
          }
        }
        for (int i = 0; i < In::kOfSource; ++i) {
          __m128i sum = _mm_add_epi32(sums[i], _mm_shuffle_epi32(sums[i], 0x4e));
          sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0xb1));
          totals[static_cast<std::size_t>(source * In::kOfSource + i)][window->start[0]] +=
              _mm_cvtsi128_si32(sum);
        }
      }
    }
    const int bits = from.block.bits;
    Sums sums;
    for (int channel = 0; channel < kChannels; ++channel) {
      const bool rounds = !kFine && !(kDeep && channel % 2 == 1);
      const Register half = Lanes::all32(rounds ? 1 << (bits - 1) : 0);
      for (int part = 0; part < kParts; ++part) {
        const int first = part * kBlockSide * Lanes::kGroups;
        sums.of[channel][part] =
            Lanes::add32(Lanes::load(totals[static_cast<std::size_t>(channel)].data() + first), half);
      }
    }
    finish<BlockKind::kWide16>(sums, bits);
    return sums;
  }

  template <int kImages>
  CUPOLA_INLINE void sum_block(const Source& from, const Images<kImages>& images, Sums (&sums)[kImages]) {
    switch (from.block.kind) {
      case BlockKind::kNarrow8:
        return sum_narrow<BlockKind::kNarrow8, kImages>(from, images, sums);
      case BlockKind::kSigned8:
        return sum_narrow<BlockKind::kSigned8, kImages>(from, images, sums);
      case BlockKind::kNarrow16:
        return sum_narrow<BlockKind::kNarrow16, kImages>(from, images, sums);
      case BlockKind::kWide16:
        break;
    }
    for (int i = 0; i < kImages; ++i) sums[i] = sum_wide(from, images[i].views.data());
  }

  // Texels for about the next tile. Windows near each other share cache lines, so two rows of each are
  // enough, other ones from block to block.
  CUPOLA_INLINE static void prefetch_texels(const WarpTable& table, const ViewTexels* views,
                                            const Window* window, std::ptrdiff_t block) {
    constexpr std::ptrdiff_t kAhead = 150;  // windows; as measured best
    const Window* last = table.windows.data() + table.windows.size() - 1;
    const Window& ahead = last - window > kAhead ? window[kAhead] : *last;
    const ViewTexels& view = views[ahead.view];
    for (int source = 0; source < In::kSources; ++source) {
      const std::ptrdiff_t stride = view.stride;
      const std::uint8_t* row = In::first(view, source, ahead.x, ahead.y) + (block & 3) * stride;
      __builtin_prefetch(row);
      __builtin_prefetch(row + kWindowSide / 2 * stride);
    }
  }

  // All bits of the pixels that have a footprint.
  CUPOLA_INLINE static Register covered(const Block& block, int part) {
    const Register bit = Lanes::load(kPixelBit.data() + part * kPartBytes / 4);
    return Lanes::equal32(Lanes::both(Lanes::all32(block.covered), bit), bit);
  }

  // Sixteen pixels into the block's four rows.
  CUPOLA_INLINE static void store(const Sums& sums, const Block& block, const TileImage<Pixel>& image) {
    Pixel* out = image.block(block.at);
    for (int part = 0; part < kParts; ++part, out += Lanes::kGroups * image.stride) {
      Register pixels = sums.of[0][part];
      if constexpr (std::is_same_v<Pixel, Rgb16>) {
        pixels = Lanes::either(pixels, Lanes::template shift_left<16>(sums.of[2][part]));
        Register blue = sums.of[4][part];
        if (block.covered != kAllPixels) {
          pixels = Lanes::both(pixels, covered(block, part));
          blue = Lanes::both(blue, covered(block, part));
        }
        if (image.across) {
          pixels = Lanes::reversed32(pixels);
          blue = Lanes::reversed32(blue);
        }
        Lanes::store_rows64(pixels, blue, out, image.stride);
        continue;
      } else if constexpr (kFine) {
        constexpr bool kTwo = std::is_same_v<Pixel, Chroma>;
        if constexpr (kTwo)
          pixels = Lanes::either(pixels, Lanes::template shift_left<16>(sums.of[kDeep ? 2 : 1][part]));
        if (block.covered != kAllPixels) {
          const Register none = Lanes::exclusive_or(covered(block, part), Lanes::all32(-1));
          pixels = Lanes::either(pixels, kTwo ? none : Lanes::both(none, Lanes::all32(kNoFine)));
        }
      } else {
        const Register red_green = Lanes::either(Lanes::template shift_left<16>(pixels),
                                                 Lanes::template shift_left<8>(sums.of[1][part]));
        pixels = Lanes::either(red_green, sums.of[2][part]);
        if (block.covered != kAllPixels) pixels = Lanes::both(pixels, covered(block, part));
        pixels = Lanes::either(pixels, Lanes::all32(static_cast<int>(kBlackXrgb)));
      }
      if (image.across) pixels = Lanes::reversed32(pixels);
      if constexpr (sizeof(Pixel) == 2) {
        Lanes::store_rows16(pixels, out, image.stride);
      } else {
        Lanes::store_rows(pixels, out, image.stride);
      }
    }
  }

  template <int kImages>
  void run_images(const WarpTable& table, const Tile& tile, Images<kImages> images) {
    const Block* block = table.blocks.data() + tile.first_block;
    const Window* window = table.windows.data() + tile.first_window;
    const WeightLine* line = table.lines.data() + tile.first_line;
    for (const Block* end = block + tile.block_count; block != end; ++block) {
      for (const TileImage<Pixel>& image : images) {
        prefetch_texels(table, image.views.data(), window, end - block);
      }
      Sums sums[kImages];
      sum_block<kImages>({*block, window, line}, images, sums);
      for (int i = 0; i < kImages; ++i) store(sums[i], *block, images[i]);
      window += block->window_count;
      line += block->line_count;
    }
  }

  // Pixels 0 to 15, each four times.
  alignas(64) static constexpr std::array<std::uint8_t, 64> kFourTimes = [] {
    std::array<std::uint8_t, 64> pixels{};
    for (std::size_t i = 0; i < 64; ++i) pixels[i] = static_cast<std::uint8_t>(i / 4);
    return pixels;
  }();
  alignas(64) static constexpr std::array<std::uint32_t, kPixelsInBlock> kPixelBit = [] {
    std::array<std::uint32_t, kPixelsInBlock> bits{};
    for (std::size_t i = 0; i < kPixelsInBlock; ++i) bits[i] = 1U << i;
    return bits;
  }();

  static constexpr int kPairBytes = 16;
  // Row pairs 0 to 7, and what shuffles that pick nothing may load.
  static constexpr int kPairs = kWindowSide + 6;
  static constexpr int kChannelBytes = kPairs * kPairBytes;
  alignas(64) std::uint8_t pairs_[kAtOnce][kChannels][kPairs][kPairBytes] = {};
};

}  // namespace cupola
