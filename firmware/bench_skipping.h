// What `cupola bench warp` times of frames that need little work, and of finding out that they do.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "firmware/bench_warp.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {

// Outlives its laps. `table` is the rig's, `faces` its RGB faces, which stay as they are; the warps run in
// `alone`, a pool of one thread.
class SkippingBench {
 public:
  SkippingBench(const Rig& rig, const WarpTable& table, std::span<const Image> faces, std::int64_t in_image,
                WorkerPool& alone);
  // Warps of frames unchanged, with a twentieth of the picture changed, and of one colour; then the comparing
  // of faces that tells which they are.
  std::vector<Lap> laps();

 private:
  using Changes = std::vector<ChangedCells>;
  // Gives `now` the faces, but for a square about the middle of the first that shows in `share` of the
  // picture.
  void change(double share);
  void compare(const std::vector<ImageBuffer>& with, Changes& changed, bool look_for_even);

  std::span<const Image> faces_;
  double in_image_;
  std::unique_ptr<FrameWarp> warp_;
  ImageBuffer frame_;
  std::vector<ImageBuffer> same_, moved_, other_, black_;
  std::vector<Image> moved_images_, black_images_;
  Changes none_, some_, scratch_;
  std::vector<EvenCells> uneven_, even_, scratch_even_;
};

}  // namespace cupola
