// narrow_rows.h's thresholds, four pixels of a row at a time.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/warp/narrow_rows.h"
#include "pipeline/warp/sse4.h"

namespace cupola {

class DitherOfFour {
 public:
  // From (x, y) to the right.
  DitherOfFour(int x, int y) {
    const auto at = [&](int pixel) {
      return static_cast<int>(static_cast<std::uint32_t>(x + pixel) * kDitherX +
                              static_cast<std::uint32_t>(y) * kDitherY);
    };
    t_ = _mm_setr_epi32(at(0), at(1), at(2), at(3));
  }

  // dither_triangle() of the next four.
  CUPOLA_INLINE __m128i next() {
    const __m128i folded = _mm_xor_si128(t_, _mm_srai_epi32(t_, 31));
    t_ = _mm_add_epi32(t_, _mm_set1_epi32(static_cast<int>(4 * kDitherX)));
    return folded;
  }

 private:
  __m128i t_;
};

}  // namespace cupola
