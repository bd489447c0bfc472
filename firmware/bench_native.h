// What `cupola bench warp` times of native pictures, beside planes of RGB that end up in the same format.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "firmware/bench_warp.h"
#include "pipeline/warp/native_warp.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {

// Outlives its laps. `table` is the rig's, `faces` its RGB faces; the warps run in `alone`, a pool of one
// thread.
class NativeBench {
 public:
  NativeBench(const Rig& rig, const WarpTable& table, std::span<const Image> faces, WorkerPool& alone,
              Cpu cpu);
  // Rows of equal names but for what comes in and goes out.
  std::vector<Lap> laps();

 private:
  Cpu cpu_;
  std::span<const Image> rgb_;
  double in_image_;
  std::vector<NativeBuffer> buffers_;
  std::vector<NativeImage> nv12_, p010_, yuyv_, rgb24_, xrgb32_;
  ImageBuffer xrgb_;
  NativeBuffer frame_;
  std::unique_ptr<FrameWarp> rgb_to_xrgb_;
  std::unique_ptr<NativeWarp<MutableNativeImage>> nv12_to_nv12_;
  std::unique_ptr<NativeWarp<MutableImage>> nv12_to_xrgb_, p010_to_xrgb_, yuyv_to_xrgb_, rgb24_to_xrgb_,
      xrgb32_to_xrgb_;
};

}  // namespace cupola
