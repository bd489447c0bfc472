// Rows into the frame with NEON: loads and stores that take channels apart and put them together, 16 pixels a
// turn.
// SPDX-License-Identifier: MIT
#include <arm_neon.h>

#include "pipeline/warp/row_store.h"

namespace cupola {
namespace {

constexpr int kTurn = 16;  // pixels

// Bytes of a pixel: b, g, r, x.
uint8x16x4_t load(const Xrgb* pixels) {
  return vld4q_u8(reinterpret_cast<const std::uint8_t*>(pixels));
}

}  // namespace

void store_row_neon(const Xrgb* pixels, int count, const MutableImage& frame, int x, int y) noexcept {
  int done = 0;
  if (frame.format == PixelFormat::kRgbPlanar8) {
    for (; done + kTurn <= count; done += kTurn) {
      const uint8x16x4_t bgrx = load(pixels + done);
      for (int channel = 0; channel < 3; ++channel) {
        vst1q_u8(frame.samples<std::uint8_t>(channel, y) + x + done, bgrx.val[2 - channel]);
      }
    }
  } else if (frame.format == PixelFormat::kRgb8) {
    for (; done + kTurn <= count; done += kTurn) {
      const uint8x16x4_t bgrx = load(pixels + done);
      const uint8x16x3_t rgb = {{bgrx.val[2], bgrx.val[1], bgrx.val[0]}};
      vst3q_u8(frame.samples<std::uint8_t>(0, y) + 3 * (x + done), rgb);
    }
  } else if (frame.format == PixelFormat::kXrgb8888) {
    for (; done + 4 <= count; done += 4) {
      vst1q_u32(frame.samples<std::uint32_t>(0, y) + x + done, vld1q_u32(pixels + done));
    }
  }
  store_row_scalar(pixels + done, count - done, frame, x + done, y);
}

}  // namespace cupola
