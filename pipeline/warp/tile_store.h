// Puts a finished tile into the frame, in the frame's own format.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/frame/image.h"
#include "pipeline/warp/tile_kernel.h"

namespace cupola {

// The part of the tile with its corner at pixel (x, y) that lies within the frame. 8 bit tiles go into frames
// of 16 by x * 257, 16 bit tiles into frames of 8 rounded to nearest.
void store_tile(const TilePixels<std::uint8_t>& pixels, int x, int y, const MutableImage& frame) noexcept;
void store_tile(const TilePixels<std::uint16_t>& pixels, int x, int y, const MutableImage& frame) noexcept;

}  // namespace cupola
