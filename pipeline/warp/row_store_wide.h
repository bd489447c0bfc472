// Rows of 16 bits a sample into frames, narrowed in pieces that stay in the first-level cache.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>

#include "pipeline/warp/narrow_rows.h"
#include "pipeline/warp/row_store.h"

namespace cupola {

// Into frames of 16 bits, as they are and from light.
void store_row_deep(const Rgb16*, int count, const MutableImage&, int x, int y) noexcept;
void store_row_deep_sse4(const Rgb16*, int count, const MutableImage&, int x, int y) noexcept;
void store_row_deep_light(const Rgb16*, int count, const MutableImage&, int x, int y) noexcept;

template <NarrowRow kNarrow, auto kStore, auto kStoreDeep>
void store_row_wide(const Rgb16* pixels, int count, const MutableImage& frame, int x, int y) noexcept {
  if (sample_bytes(frame.format) == 2) return kStoreDeep(pixels, count, frame, x, y);
  constexpr int kPiece = 1024;
  Xrgb piece[kPiece];
  for (int done = 0; done < count; done += kPiece) {
    const int some = std::min(kPiece, count - done);
    kNarrow(pixels + done, some, x + done, y, piece);
    kStore(piece, some, frame, x + done, y);
  }
}

// The four narrowings with one way to store.
template <NarrowRow kRounded, NarrowRow kDithered, auto kStore, auto kStoreDeep>
auto wide_store(Narrowing narrowing) {
  switch (narrowing) {
    case Narrowing::kRounded:
      return store_row_wide<kRounded, kStore, kStoreDeep>;
    case Narrowing::kDithered:
      return store_row_wide<kDithered, kStore, kStoreDeep>;
    case Narrowing::kFromLight:
      return store_row_wide<narrow_light, kStore, store_row_deep_light>;
    case Narrowing::kFromLightDithered:
      break;
  }
  return store_row_wide<narrow_light_dithered, kStore, store_row_deep_light>;
}

}  // namespace cupola
