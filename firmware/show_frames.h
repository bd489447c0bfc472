// A show made ready: every cue opened and its warp built, so that frames can be made without allocating.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/change_history.h"
#include "firmware/frame_maker.h"
#include "firmware/show.h"
#include "firmware/timeline.h"
#include "pipeline/warp/frame_warp.h"

namespace cupola {

class ShowFrames final : public FrameMaker {
 public:
  // Throws InputError. `pool` is borrowed for the show's life. With `whole_faces` sources make every texel,
  // not only those the warp reads. Tables come from `cache`, where there is one.
  ShowFrames(const Show& show, Method method, Cpu cpu, WorkerPool& pool, bool whole_faces = false,
             TableCache* cache = nullptr);

  Size frame_size() const { return frame_size_; }
  double rate() const override { return rate_; }  // of the first cue
  PixelFormat format() const;            // of the faces: 16 bits if any cue has 16
  const Timeline& timeline() const { return timeline_; }

  Change advance(std::chrono::nanoseconds time, std::chrono::nanoseconds flip) noexcept override;
  WarpWork warp(const MutableImage& frame, int age) noexcept override;
  void shown(std::chrono::nanoseconds /*flipped_at*/) noexcept override {}

  const FaceSet& faces() const { return faces_; }
  const Rig& rig() const { return cues_[moment_.cue].rig; }
  const std::string& cue_name() const { return cues_[moment_.cue].name; }
  std::string trouble() const override;

 private:
  struct OpenCue {
    std::string name;
    Rig rig;  // with the sizes of the source's faces
    std::unique_ptr<FaceSource> source;
    std::size_t warp = 0;
  };
  struct CueWarp {  // shared by cues with faces of the same sizes
    std::unique_ptr<FrameWarp> warp;
    ChangeHistory history;
  };

  Size frame_size_;
  double rate_ = 60.0;
  std::vector<OpenCue> cues_;
  std::vector<CueWarp> warps_;
  Timeline timeline_;
  Moment moment_{0, -1};
  bool asked_ = false;                      // moment_ was asked for ...
  bool failed_ = false;                     // ... in vain
  std::optional<std::size_t> shown_cue_;    // whose faces were fetched last
  std::optional<std::size_t> warped_with_;  // which of warps_ made the last frame
  FaceSet faces_;
};

}  // namespace cupola
