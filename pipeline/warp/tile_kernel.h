// What a warp kernel is: one tile of the table, executed. The scalar kernel defines the answer; the others
// give the same bits. SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "pipeline/warp/cpu.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {

// The planes of one view, 8 bits a sample (or 16 for the wide kernel); strides in bytes.
struct ViewTexels {
  std::array<const std::uint8_t*, 3> plane{};
  std::array<std::ptrdiff_t, 3> stride{};
};

// The tile's pixels by channel, row by row.
template <class Sample>
struct alignas(64) TilePixels {
  std::array<std::array<Sample, kTileSide * kTileSide>, 3> channel;
};

// Where block `i` of a tile begins within a channel of TilePixels.
constexpr int first_pixel(int i) {
  return i / kBlocksAcross * kBlockSide * kTileSide + i % kBlocksAcross * kBlockSide;
}

using TileKernel = void (*)(const WarpTable& table, int tile, std::span<const ViewTexels> views,
                            TilePixels<std::uint8_t>& pixels) noexcept;

void run_tile_scalar(const WarpTable&, int tile, std::span<const ViewTexels>,
                     TilePixels<std::uint8_t>&) noexcept;
void run_tile_avx2(const WarpTable&, int tile, std::span<const ViewTexels>,
                   TilePixels<std::uint8_t>&) noexcept;
void run_tile_avx512(const WarpTable&, int tile, std::span<const ViewTexels>,
                     TilePixels<std::uint8_t>&) noexcept;

// 16 bits a sample, any instruction set.
void run_tile_wide(const WarpTable&, int tile, std::span<const ViewTexels>,
                   TilePixels<std::uint16_t>&) noexcept;

TileKernel tile_kernel(Cpu cpu);

}  // namespace cupola
