// Puts finished pixels into the frame, a row at a time, in the frame's own format.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/frame/image.h"
#include "pipeline/warp/tile_kernel.h"

namespace cupola {

// The fast ones write past the caches: whoever reads the frame next is another device or comes much later.
template <class Pixel>
struct RowStore {
  // `count` pixels to (x, y) and on to the right. 8 bits go into frames of 16 by v * 257, 16 into frames of 8
  // rounded to nearest.
  void (*store)(const Pixel* pixels, int count, const MutableImage& frame, int x, int y) noexcept;
  // After the last row that a thread stores, before others may look: writes past the caches are not ordered
  // by what locks and atomics do.
  void (*finish)() noexcept;
};

void store_row_scalar(const Xrgb*, int count, const MutableImage&, int x, int y) noexcept;
void store_row_sse4(const Xrgb*, int count, const MutableImage&, int x, int y) noexcept;
void store_row_avx512(const Xrgb*, int count, const MutableImage&, int x, int y) noexcept;
void store_row_neon(const Xrgb*, int count, const MutableImage&, int x, int y) noexcept;

void finish_rows_scalar() noexcept;
void finish_rows_streamed() noexcept;  // x86

RowStore<Xrgb> row_store(Cpu cpu);

// From 16 bits to 8. Light goes to sRGB, of as many bits as the frame has.
enum class Narrowing : std::uint8_t { kRounded, kDithered, kFromLight, kFromLightDithered };
RowStore<Rgb16> wide_row_store(Cpu cpu, Narrowing narrowing);

}  // namespace cupola
