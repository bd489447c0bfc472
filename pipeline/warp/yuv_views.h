// YUV faces as the kernels read them: luma and chroma apart, seen by every reflection of the frame.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/frame/yuv_image.h"
#include "pipeline/warp/band_run.h"

namespace cupola {

// Bytes from a texel to the next.
constexpr int luma_step(YuvLayout layout) {
  return is_packed(layout) ? 2 : 1;
}
constexpr int chroma_step(YuvLayout layout) {
  return is_packed(layout) ? 4 : layout == YuvLayout::kNv12 ? 2 : 1;
}

class YuvViews {
 public:
  // Pictures with fewer texels than a window, in luma or chroma, are copied into memory of its size; tables
  // never weigh what lies beyond.
  YuvViews(YuvLayout layout, std::span<const Size> faces);

  // Valid until the next call; `faces` are borrowed as long.
  void set(std::span<const YuvImage> faces);
  ReflectedViews luma(const WarpTable& table) const;
  ReflectedViews chroma(const WarpTable& table) const;

 private:
  YuvLayout layout_;
  std::vector<YuvBuffer> padded_;  // without planes where there is no need
  std::vector<YuvImage> faces_;
};

}  // namespace cupola
