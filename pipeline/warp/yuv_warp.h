// YUV pictures warped as they come: luma and chroma each by a table of its own, no conversion of faces.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>

#include "pipeline/frame/yuv_image.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/cpu.h"

namespace cupola {

// Immutable once made, but for scratch memory; one warp() at a time, which neither allocates nor throws.
template <class Frame>
class YuvWarp {
 public:
  virtual ~YuvWarp() = default;
  // `faces` in the rig's order, of the rig's sizes, all of the layout the warp was made for and of one
  // colour. Every pixel of `frame`, which has the rig's frame size, is written; those outside the image are
  // black.
  virtual void warp(std::span<const YuvImage> faces, const Frame& frame) noexcept = 0;
  virtual std::size_t table_bytes() const = 0;
};

// The rig's views must have sizes. `pool` is borrowed for the warp's life.

// Into frames of NV12, which take over the faces' colour: 4:2:0 stays 4:2:0, and luma is to the bit what a
// grey picture gives. Throws InputError where half_frame_chroma_rig() does.
std::unique_ptr<YuvWarp<MutableYuvImage>> make_nv12_warp(const Rig& rig, YuvLayout faces, Cpu cpu,
                                                         WorkerPool& pool);

// Into frames of PixelFormat::kXrgb8888.
std::unique_ptr<YuvWarp<MutableImage>> make_yuv_to_xrgb_warp(const Rig& rig, YuvLayout faces, Cpu cpu,
                                                             WorkerPool& pool);

}  // namespace cupola
