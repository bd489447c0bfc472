// Native pictures as the kernels read them, luma and chroma apart, seen by every reflection of the frame.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/frame/native_image.h"
#include "pipeline/optics/view.h"
#include "pipeline/warp/band_run.h"

namespace cupola {

// Bytes from a texel of chroma to the next.
constexpr int chroma_step(NativeLayout layout) {
  return is_packed(layout) ? 4 : is_half_planar(layout) ? 2 * sample_bytes(layout) : 1;
}

class NativeViews {
 public:
  // Pictures with fewer texels than a window, in luma or chroma, are copied into memory of its size; tables
  // never weigh what lies beyond.
  NativeViews(NativeLayout layout, std::span<const View> views);

  std::span<const Size> sizes() const { return sizes_; }

  // Whether face `i` is one of those.
  bool copies(std::size_t i) const { return padded_[i].pixels().planes[0].data != nullptr; }

  // Valid until the next call; `faces` are borrowed as long.
  void set(std::span<const NativeImage> faces);
  ReflectedViews rgb(const WarpTable& table) const;
  ReflectedViews luma(const WarpTable& table) const;
  ReflectedViews chroma(const WarpTable& table) const;

 private:
  NativeLayout layout_;
  std::vector<Size> sizes_;
  std::vector<NativeBuffer> padded_;  // without planes where there is no need
  std::vector<NativeImage> faces_;
};

}  // namespace cupola
