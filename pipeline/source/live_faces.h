// Faces from cameras: one a view, in step, as the drivers' own buffers.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/camera/camera_watch.h"
#include "hal/time/clock.h"
#include "pipeline/frame/yuv_image.h"
#include "pipeline/source/rig_sync.h"

namespace cupola {

// The camera of a view, and what its frames are agreed to be.
struct LiveView {
  std::string name;               // on its slate
  CameraWatch* camera = nullptr;  // borrowed for the faces' life; null: the view shows its slate for ever
  CameraMode mode;                // without a camera: of the slate
};

struct LiveCounts {
  std::uint64_t pixel_bytes_copied = 0;  // last pictures of cameras that were lost
  std::uint64_t unlike = 0;              // frames that were not as agreed: given back unseen
};

// The layout that a camera's frames are in; false for formats that the warp does not read.
bool layout_of(CameraFormat format, YuvLayout& layout);
YuvColour colour_of(const CameraMode& mode);

// One thread. After construction it allocates only where a camera's start does.
class LiveFaces {
 public:
  // All views of one layout and colour; each mode has a size. Throws std::bad_alloc.
  LiveFaces(std::vector<LiveView> views, Clock& clock, const SyncSettings& settings);
  ~LiveFaces();
  LiveFaces(const LiveFaces&) = delete;
  LiveFaces& operator=(const LiveFaces&) = delete;

  // Takes what the cameras send until `deadline`; asks each once at least.
  void gather(std::chrono::nanoseconds deadline) noexcept;
  // Puts the newest frames in step into faces(). True when one differs from the last call's.
  bool choose() noexcept;

  // In the order of the views. Borrowed until the next gather().
  std::span<const YuvImage> faces() const { return faces_; }
  const RigSync& sync() const { return sync_; }
  const LiveCounts& counts() const { return counts_; }

 private:
  void collect(std::size_t view) noexcept;
  void lose(std::size_t view) noexcept;
  void give_back_spent() noexcept;

  std::vector<LiveView> views_;
  Clock& clock_;
  RigSync sync_;
  std::vector<YuvBuffer> slates_;
  std::vector<YuvBuffer> kept_;  // copies of lost cameras' last pictures
  std::vector<YuvImage> faces_;
  std::vector<int> descriptors_;
  LiveCounts counts_;
};

}  // namespace cupola
