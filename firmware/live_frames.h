// A live show: cameras in step, one warp from their buffers into the display's, as late as the flip allows.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "firmware/frame_maker.h"
#include "firmware/rig_cameras.h"
#include "hal/camera/camera_watch.h"
#include "hal/time/clock.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/source/live_faces.h"
#include "pipeline/warp/yuv_warp.h"

namespace cupola {

// One rig camera and the device that was made for it.
struct OpenCamera {
  RigCamera settings;
  std::unique_ptr<Camera> device;
};

class LiveFrames final : public FrameMaker {
 public:
  // Starts every camera and gives each three seconds; one that does not start shows its slate until it comes,
  // if its size and format are in the rig. Views without a camera show their slates. Throws Failure where no
  // warp can be made of what the cameras send. `clock` and `pool` are borrowed for the show's life.
  LiveFrames(const Rig& rig, std::vector<OpenCamera> cameras, const SyncSettings& settings, Cpu cpu,
             WorkerPool& pool, Clock& clock);

  Change advance(const Due& due) noexcept override;
  WarpWork warp(const MutableImage& frame, int age) noexcept override;
  void shown(std::chrono::nanoseconds flipped_at) noexcept override;
  double rate() const override { return rate_; }
  std::string trouble() const override { return {}; }

  const Rig& rig() const { return rig_; }
  const LiveFaces& faces() const { return *faces_; }
  std::int64_t pixel_bytes_copied() const {
    return static_cast<std::int64_t>(faces_->counts().pixel_bytes_copied);
  }
  // One a rig camera, in the rig file's order.
  const std::vector<OpenCamera>& cameras() const { return cameras_; }
  const CameraWatch& watch(std::size_t camera) const { return *watches_[camera]; }
  // From the time that a set was captured to the flip that first showed it; milliseconds, the last 65,536
  // sets.
  std::vector<double> latencies_ms() const;

 private:
  std::vector<LiveView> start_cameras();

  Rig rig_;
  std::vector<OpenCamera> cameras_;
  Clock& clock_;
  std::vector<std::unique_ptr<CameraWatch>> watches_;
  std::unique_ptr<LiveFaces> faces_;
  std::unique_ptr<YuvWarp<MutableImage>> warp_;
  double rate_ = 60.0;
  std::chrono::nanoseconds lead_;  // before the flip the faces are chosen: what a warp takes and a margin
  bool fresh_ = false;             // the set shown next was not shown before
  std::vector<std::chrono::nanoseconds> latencies_;  // a ring
  std::size_t shown_ = 0;
};

}  // namespace cupola
