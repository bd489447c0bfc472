// Faces from cameras: one a view, in step, as the drivers' own buffers.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/camera/camera_watch.h"
#include "hal/time/clock.h"
#include "pipeline/frame/native_image.h"
#include "pipeline/optics/view.h"
#include "pipeline/source/rig_sync.h"

namespace cupola {

// The camera of a view, and what its frames are agreed to be.
struct LiveView {
  std::string name;               // on its slate
  CameraWatch* camera = nullptr;  // borrowed for the faces' life; null: the view shows its slate for ever
  CameraMode mode;                // of the whole picture; without a camera: of the slate
  TexelBox needed;                // of it: what is looked at. Frames may be any part that holds it
};

struct LiveCounts {
  std::uint64_t pixel_bytes_copied = 0;  // last pictures of cameras that were lost
  std::uint64_t unlike = 0;              // frames that were not as agreed: given back unseen
};

// The layout that the warp reads a camera's frames as; none for formats that it does not read. Grey pictures
// are kI420 without colour.
std::optional<NativeLayout> layout_of(CameraFormat format);
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

  // In the order of the views, of the whole pictures' sizes, with no more than the needed texels in memory.
  // Borrowed until the next gather().
  std::span<const NativeImage> faces() const { return faces_; }
  const TexelBox& needed(std::size_t view) const { return views_[view].needed; }
  // Bit v: the last choose() gave view v another picture than it had.
  unsigned changed() const { return changed_; }
  const RigSync& sync() const { return sync_; }
  const LiveCounts& counts() const { return counts_; }

 private:
  void collect(std::size_t view) noexcept;
  void lose(std::size_t view) noexcept;
  NativeImage image_of(std::size_t view, const CameraFrame& frame) noexcept;
  void give_back_spent() noexcept;

  std::vector<LiveView> views_;
  Clock& clock_;
  RigSync sync_;
  std::vector<NativeBuffer> slates_;
  std::vector<NativeBuffer> kept_;      // copies of lost cameras' last pictures
  std::vector<std::uint8_t> grey_row_;  // every row of the chroma of pictures without
  std::vector<TexelBox> sent_;          // by the cameras, of the whole pictures
  // Which picture a view shows.
  struct Shown {
    bool slate = false;
    int buffer = -1;
    std::uint64_t sequence = 0;
    std::chrono::nanoseconds captured_at{-1};
    friend bool operator==(const Shown&, const Shown&) = default;
  };

  std::vector<NativeImage> faces_;
  std::vector<Shown> shown_;
  unsigned changed_ = 0;
  std::vector<int> descriptors_;
  LiveCounts counts_;
};

}  // namespace cupola
