// Live pictures: cameras in step, one warp from their buffers into the display's, as late as the flip allows.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "firmware/change_history.h"
#include "firmware/frame_maker.h"
#include "firmware/open_cameras.h"
#include "firmware/rig_devices.h"
#include "firmware/time_ring.h"
#include "hal/time/clock.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/source/exposure_drive.h"
#include "pipeline/source/frame_alignment.h"
#include "pipeline/source/live_faces.h"
#include "pipeline/warp/colour_match.h"
#include "pipeline/warp/native_warp.h"

namespace cupola {

class LiveFrames final : public FrameMaker {
 public:
  // Starts every camera and gives each three seconds; one that does not start shows its slate until it comes,
  // if its size and format are in the rig. Cameras are then cropped to what the warp looks at, where they can
  // and it spares an eighth or more; those that it does not look at are stopped. Views without a camera show
  // their slates. Colours that cameras have in the rig are theirs; with `match_colours` the others are
  // matched where pictures overlap. Without a cache the tables are built. Throws Failure where no warp can be
  // made of what the cameras send, into XRGB8888 and, if the settings have it, NV12. `clock` and `pool` are
  // borrowed for the show's life, `cache` for the call.
  LiveFrames(const Rig& rig, std::vector<OpenCamera> cameras, const LiveSettings& settings, Cpu cpu,
             WorkerPool& pool, Clock& clock, TableCache* cache = nullptr);

  Change advance(const Due& due) noexcept override;
  WarpWork warp(const MutableImage& frame, int age) noexcept override;
  std::optional<YuvColour> nv12_colour() const noexcept override;
  bool gives_nv12() const noexcept override { return nv12_warp_ != nullptr; }
  WarpWork warp_nv12(const MutableNativeImage& frame, int age) noexcept override;
  FacePicture face(std::size_t view) const noexcept override;
  void shown(std::chrono::nanoseconds flipped_at) noexcept override;
  double rate() const override { return rate_; }            // the first camera's
  void report(ShowReport& report) const noexcept override;  // of the cameras alone

  // In place of advance() while something else is seen: takes what the cameras have sent, without waiting, so
  // that they go on and stay in step.
  void advance_unseen() noexcept;
  // Something else was warped since the last warp().
  void forget_frames() noexcept { history_->fetched({}); }
  // The last warp() was part of something longer, which began at `begun` of clock() and has just ended.
  void note_warp_since(std::chrono::nanoseconds begun) noexcept;
  Clock& clock() const { return clock_; }

  const Rig& rig() const { return rig_; }
  const LiveFaces& faces() const { return *faces_; }
  std::int64_t pixel_bytes_copied() const {
    return static_cast<std::int64_t>(faces_->counts().pixel_bytes_copied);
  }
  // One a rig camera, in the rig file's order.
  const std::vector<OpenCamera>& cameras() const { return cameras_; }
  // From the time that a set was captured to the flip that first showed it; milliseconds, the last 65,536
  // sets.
  std::vector<double> latencies_ms() const { return latencies_.milliseconds(); }

 private:
  std::vector<LiveView> start_cameras();
  void crop_cameras(std::span<LiveView> views);
  void begin_colours(const CameraMode& mode, bool match);
  void begin_nv12(const CameraMode& mode, Cpu cpu, WorkerPool& pool, TableCache* cache);
  std::vector<TexelBox> reads() const;
  template <class Frame>
  WarpWork warp_by(NativeWarp<Frame>& warp, const Frame& frame, int age) noexcept;
  bool follow_cameras() noexcept;  // whether what is made of their pictures has changed
  bool follow_colours(unsigned seen) noexcept;
  void follow_exposure(unsigned seen) noexcept;
  void follow_offsets() noexcept;
  void wait_for_starts(std::span<const LiveView> views);
  const OpenCamera* camera_of(const std::string& view) const;  // null: none

  Rig rig_;
  std::vector<OpenCamera> cameras_;
  Clock& clock_;
  std::unique_ptr<LiveFaces> faces_;
  std::unique_ptr<NativeWarp<MutableImage>> warp_;
  std::unique_ptr<NativeWarp<MutableNativeImage>> nv12_warp_;  // null: nobody takes NV12
  std::unique_ptr<ColourMatch> match_;                         // null: colours stay what they are
  std::vector<ViewColour> locked_;  // one a view, where there is no match but a camera has a colour
  std::optional<ExposureDrive> exposure_;
  std::optional<FrameAlignment> alignment_;
  std::vector<ChangedCells> changed_;  // one a view: all of it or nothing
  std::unique_ptr<ChangeHistory> history_;
  std::vector<CameraWatch*> watches_;  // one a view; null: none, or not looked at
  double rate_ = 60.0;
  std::chrono::nanoseconds lead_;  // before the flip the faces are chosen: what a warp takes and a margin
  bool fresh_ = false;             // the set shown next was not shown before
  TimeRing latencies_;
};

}  // namespace cupola
