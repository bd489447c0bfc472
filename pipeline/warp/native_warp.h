// Native pictures warped as they come: RGB by one table, luma and chroma of YUV by one each.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "pipeline/frame/native_image.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/cpu.h"
#include "pipeline/warp/frame_warp.h"
#include "pipeline/warp/table_cache.h"
#include "pipeline/warp/view_colour.h"

namespace cupola {

// Immutable once made, but for scratch memory; one warp() at a time, which neither allocates nor throws.
template <class Frame>
class NativeWarp {
 public:
  virtual ~NativeWarp() = default;
  // `faces` in the rig's order, of the rig's sizes, all of the layout the warp was made for and of one
  // colour. Every pixel of `frame`, which has the rig's frame size, is written; those outside the image are
  // black.
  void warp(std::span<const NativeImage> faces, const Frame& frame) noexcept {
    warp_changed(faces, ~0U, frame);
  }
  // The same where bit v of `changed` is 0 only for views whose picture is the one that made what `frame`
  // holds: tiles that show none of the others are left as they are. What was done and left out, in tiles.
  virtual WarpWork warp_changed(std::span<const NativeImage> faces, unsigned changed,
                                const Frame& frame) noexcept = 0;
  // What warp() loads of each face, in texels of luma, with even sides but for the last row and column:
  // planes need to hold no more. Empty: nothing.
  virtual std::vector<TexelBox> reads() const = 0;
  virtual std::size_t table_bytes() const = 0;

  // Before the first warp: makes ready for colours other than the views' own; allocates. False where this
  // warp has none: of YUV into XRGB8888 it has. `rig` is the one the warp was made for.
  virtual bool prepare_colours([[maybe_unused]] const Rig& rig) { return false; }
  // From the next warp on; one a view. A frame that holds earlier colours has to be warped as a whole.
  virtual void set_colours([[maybe_unused]] std::span<const ViewColour> colours) noexcept {}
};

// The rig's views must have sizes. `pool` is borrowed for the warp's life. Without a cache tables are built.

// Into frames of NV12, which take over the faces' colour: 4:2:0 stays 4:2:0, and luma is to the bit what a
// grey picture gives. Throws InputError for faces of RGB, and where half_frame_chroma_rig() does.
std::unique_ptr<NativeWarp<MutableNativeImage>> make_nv12_warp(const Rig& rig, NativeLayout faces, Cpu cpu,
                                                               WorkerPool& pool, TableCache* cache = nullptr);

// Into frames of PixelFormat::kXrgb8888.
std::unique_ptr<NativeWarp<MutableImage>> make_native_to_xrgb_warp(const Rig& rig, NativeLayout faces,
                                                                   Cpu cpu, WorkerPool& pool,
                                                                   TableCache* cache = nullptr);

}  // namespace cupola
