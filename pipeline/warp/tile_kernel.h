// What a warp kernel is: one tile of the table, executed. The scalar kernel defines the answer; the others
// give the same bits.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "pipeline/warp/cpu.h"
#include "pipeline/warp/warp_table.h"

// For the parts of kernels that are only fast within the loop that calls them.
#define CUPOLA_INLINE [[gnu::always_inline]] inline

namespace cupola {

// One view as one reflection of the frame sees it. A view mirrored top to bottom is walked with a negative
// stride, one mirrored left to right with its windows' columns turned round.
struct ViewTexels {
  const std::uint8_t* origin = nullptr;     // the window at (0, 0) of the first channel
  std::array<std::ptrdiff_t, 3> channel{};  // bytes from there to the same window of each channel
  std::ptrdiff_t stride = 0;                // bytes from a texel row to the next, in all channels
  std::ptrdiff_t step = 1;                  // bytes from a texel to the next within a window
  std::ptrdiff_t across = 1;                // bytes from a window to the one at x + 1
  std::uint32_t flip = 0;                   // XORed to a column within a window, 0 or 7; in all four bytes

  // Planes may be apart in memory; C++ has no difference of pointers for that.
  static std::ptrdiff_t bytes_between(const void* from, const void* to) {
    return static_cast<std::ptrdiff_t>(reinterpret_cast<std::uintptr_t>(to) -
                                       reinterpret_cast<std::uintptr_t>(from));
  }

  const std::uint8_t* window(int x, int y) const { return origin + y * stride + x * across; }
  const std::uint8_t* window(int of_channel, int x, int y) const {
    return window(x, y) + channel[of_channel];
  }
  int column(int column) const { return column ^ static_cast<int>(flip & 7); }
};

// Finished pixels before they go into the frame's format.
using Xrgb = std::uint32_t;  // 0xffRRGGBB
struct Rgb16 {
  std::uint16_t r = 0, g = 0, b = 0, unused = 0;
};
inline constexpr Xrgb kBlackXrgb = 0xff000000;

// Sums on their way to YUV frames or to a conversion: kFineBits fractional bits, rounded down. Whoever rounds
// later to fewer bits has rounded the sum itself, since floors nest; kMostFine is the largest that does not
// round up to 256.
using Luma = std::uint16_t;
struct Chroma {
  std::uint16_t u = 0, v = 0;
};
inline constexpr int kFineBits = 6;
inline constexpr int kMostFine = 255 * 64 + 31;
inline constexpr int kMostWideFine =
    65535 / 4;  // of samples of 16 bits: 256 of their steps are one of 8 bits
inline constexpr std::uint16_t kNoFine = 0xffff;  // a pixel without a footprint

// What pixels without a footprint are.
template <class Pixel>
inline constexpr Pixel kBlack{};
template <>
inline constexpr Xrgb kBlack<Xrgb> = kBlackXrgb;
template <>
inline constexpr Luma kBlack<Luma> = kNoFine;
template <>
inline constexpr Chroma kBlack<Chroma>{kNoFine, kNoFine};

// Where one reflection of a tile comes from and goes to.
template <class Pixel>
struct TileImage {
  std::span<const ViewTexels> views;
  Pixel* corner = nullptr;    // the tile's first pixel
  std::ptrdiff_t stride = 0;  // pixels from one row of the tile to the next
  bool across = false;        // mirrored left to right: the tile's pixels run leftward from `corner`

  // The leftmost pixel of a block's first row.
  Pixel* block(int at) const { return corner + (across ? offset<true>(at) : offset<false>(at)); }
  // From `corner` to the leftmost pixel of a block's first row.
  template <bool kAcross>
  std::ptrdiff_t offset(int block_at) const {
    const int x = block_at % kBlocksAcross * kBlockSide;
    const int y = block_at / kBlocksAcross * kBlockSide;
    return y * stride + (kAcross ? -x - (kBlockSide - 1) : x);
  }
};

// The lines are read once a frame, from memory. Hardware foresees that within a page only, which left a fifth
// of the AVX-512 kernel's time waiting. As far ahead as measured best; past the table's end it does nothing.
CUPOLA_INLINE void prefetch_after(const WeightLine* line) {
  __builtin_prefetch(reinterpret_cast<const char*>(line) + 24 * sizeof(WeightLine));
}

// Writes the tile's blocks, nothing of the other pixels.
template <class Pixel>
using TileKernel = void (*)(const WarpTable& table, const Tile& tile,
                            std::span<const TileImage<Pixel>> images) noexcept;

void run_tile_scalar(const WarpTable&, const Tile&, std::span<const TileImage<Xrgb>>) noexcept;
void run_tile_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Xrgb>>) noexcept;
void run_tile_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Xrgb>>) noexcept;
void run_tile_avx512(const WarpTable&, const Tile&, std::span<const TileImage<Xrgb>>) noexcept;
void run_tile_neon(const WarpTable&, const Tile&, std::span<const TileImage<Xrgb>>) noexcept;

// 16 bits a sample; with sRGB texels of 8 and of 16 bits made linear light.
void run_wide_scalar(const WarpTable&, const Tile&, std::span<const TileImage<Rgb16>>) noexcept;
void run_wide_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Rgb16>>) noexcept;
void run_wide_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Rgb16>>) noexcept;
void run_wide_avx512(const WarpTable&, const Tile&, std::span<const TileImage<Rgb16>>) noexcept;
void run_linear_scalar(const WarpTable&, const Tile&, std::span<const TileImage<Rgb16>>) noexcept;
void run_wide_linear_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Rgb16>>) noexcept;
void run_wide_linear_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Rgb16>>) noexcept;
void run_linear_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Rgb16>>) noexcept;
void run_linear_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Rgb16>>) noexcept;
void run_linear_avx512(const WarpTable&, const Tile&, std::span<const TileImage<Rgb16>>) noexcept;
void run_wide_linear_scalar(const WarpTable&, const Tile&, std::span<const TileImage<Rgb16>>) noexcept;

// RGB out of texels of three bytes, in whatever order, and of four, B G R and one more.
void run_rgb3_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Xrgb>>) noexcept;
void run_rgb4_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Xrgb>>) noexcept;
void run_rgb3_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Xrgb>>) noexcept;
void run_rgb4_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Xrgb>>) noexcept;
void run_rgb3_avx512(const WarpTable&, const Tile&, std::span<const TileImage<Xrgb>>) noexcept;
void run_rgb4_avx512(const WarpTable&, const Tile&, std::span<const TileImage<Xrgb>>) noexcept;

// One and two channels; `step` of all views' texels is what the fast ones are named for.
void run_luma_scalar(const WarpTable&, const Tile&, std::span<const TileImage<Luma>>) noexcept;
void run_chroma_scalar(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;
void run_luma1_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Luma>>) noexcept;
void run_luma2_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Luma>>) noexcept;
void run_chroma1_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;
void run_chroma2_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;
void run_chroma4_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;
void run_luma1_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Luma>>) noexcept;
void run_luma2_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Luma>>) noexcept;
void run_chroma1_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;
void run_chroma2_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;
void run_chroma4_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;
void run_luma1_avx512(const WarpTable&, const Tile&, std::span<const TileImage<Luma>>) noexcept;
void run_luma2_avx512(const WarpTable&, const Tile&, std::span<const TileImage<Luma>>) noexcept;
void run_chroma1_avx512(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;
void run_chroma2_avx512(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;
void run_chroma4_avx512(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;

// The same of 16 bits a sample, low byte first.
void run_wide_luma_scalar(const WarpTable&, const Tile&, std::span<const TileImage<Luma>>) noexcept;
void run_wide_chroma_scalar(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;
void run_wide_luma_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Luma>>) noexcept;
void run_wide_chroma_sse4(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;
void run_wide_luma_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Luma>>) noexcept;
void run_wide_chroma_avx2(const WarpTable&, const Tile&, std::span<const TileImage<Chroma>>) noexcept;

TileKernel<Xrgb> tile_kernel(Cpu cpu);
TileKernel<Rgb16> wide_kernel(Cpu cpu);          // of texels of 16 bits
TileKernel<Rgb16> linear_kernel(Cpu cpu);        // of texels of 8 bits, in linear light
TileKernel<Rgb16> wide_linear_kernel(Cpu cpu);   // of texels of 16 bits, in linear light
TileKernel<Xrgb> rgb_kernel(Cpu cpu, int step);  // 3 or 4 bytes a texel
TileKernel<Luma> luma_kernel(Cpu cpu, int step);
TileKernel<Chroma> chroma_kernel(Cpu cpu, int step);
TileKernel<Luma> wide_luma_kernel(Cpu cpu);      // 2 bytes a texel
TileKernel<Chroma> wide_chroma_kernel(Cpu cpu);  // 4

}  // namespace cupola
