// Trying filters on this machine: their error on small frames of generated worlds, their time on whole ones.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "firmware/dial.h"
#include "hal/time/clock.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/source/generated_source.h"
#include "pipeline/warp/frame_warp.h"

namespace cupola {

// The same frame and views with sides divided so that the frame's longer one has at most `most` pixels: as
// many texels a pixel as before.
Rig shrunk(const Rig& rig, int most);

// Everything is borrowed for the trial's life; the rig's views have sizes.
class MachineTrial final : public DialTrial {
 public:
  static constexpr int kSmallSide = 256;  // pixels
  static constexpr int kFrames = 15;      // timed, after two that are not

  MachineTrial(const Rig& rig, bool deep, Cpu cpu, WorkerPool& pool, TableCache* cache, Clock& clock);

  Sketch sketch(const FilterSettings& filter) override;
  double milliseconds(const FilterSettings& filter) override;

 private:
  struct World {
    std::unique_ptr<GeneratedSource> source;
    FaceSet set;
    std::vector<double> truth;  // as render_truth_exact gives it
  };
  double median_ms(FrameWarp& warp, std::span<const Image> faces, Size frame) const;
  double squared_error(const Image& frame, const std::vector<double>& truth) const;

  const Rig& rig_;
  bool deep_;
  Cpu cpu_;
  WorkerPool& pool_;
  TableCache* cache_;
  Clock& clock_;
  Rig small_;
  std::vector<std::uint8_t> small_image_;  // 1: the small frame's pixel is in the image
  std::vector<World> worlds_;
  double scale_ = 1.0;                // pixels of the rig's image to one of the small one's
  std::vector<ImageBuffer> buffers_;  // noise, for whole frames
  std::vector<Image> noise_;
};

}  // namespace cupola
