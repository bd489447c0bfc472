// What `cupola bench warp` times of YUV faces, beside RGB ones that end up in the same format.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "firmware/bench_warp.h"
#include "pipeline/warp/warp_table.h"
#include "pipeline/warp/yuv_warp.h"

namespace cupola {

// Outlives its laps. `table` is the rig's, `faces` its RGB faces; the warps run in `alone`, a pool of one
// thread.
class YuvBench {
 public:
  YuvBench(const Rig& rig, const WarpTable& table, std::span<const Image> faces, WorkerPool& alone);
  // Rows of equal names but for what comes in and goes out, all with the fastest kernels.
  std::vector<Lap> laps();

 private:
  std::span<const Image> rgb_;
  double in_image_;
  std::vector<YuvBuffer> buffers_;
  std::vector<YuvImage> nv12_, yuyv_;
  ImageBuffer xrgb_;
  YuvBuffer frame_;
  std::unique_ptr<FrameWarp> rgb_to_xrgb_;
  std::unique_ptr<YuvWarp<MutableYuvImage>> nv12_to_nv12_;
  std::unique_ptr<YuvWarp<MutableImage>> nv12_to_xrgb_, yuyv_to_xrgb_;
};

}  // namespace cupola
