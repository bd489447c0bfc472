// Which frames of several free-running cameras belong together: sets by timestamp, the newest that is whole.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "hal/camera/camera.h"

namespace cupola {

struct SyncSettings {
  // Frames whose timestamps differ by no more belong together; and how long after a set's first frame has
  // come the others are waited for. Half a frame period is the largest that makes sense.
  std::chrono::nanoseconds tolerance{std::chrono::milliseconds(4)};
  // How long a late camera's last picture is shown; after that its slate.
  std::chrono::nanoseconds patience{std::chrono::milliseconds(500)};
};

// What is shown of one camera.
struct SyncedFace {
  enum class State : std::uint8_t {
    kInStep,  // `frame` belongs to the set
    kLate,    // `frame` is its last one, for the patience
    kSlate,   // it has none to show
  };
  State state = State::kSlate;
  CameraFrame frame;
};

// The clock of one camera against the first: means over the last seconds.
struct SyncOffset {
  std::chrono::nanoseconds offset{0};
  double drift_ppm = 0.0;  // what the offset gains, nanoseconds a millisecond
};

struct SyncCounts {
  std::uint64_t sets = 0;         // chosen
  std::uint64_t whole = 0;        // of these: every camera in step
  std::uint64_t passed_over = 0;  // frames that were in no chosen set
};

// One thread. Does not allocate after construction. Frames are lent to it by offer(); those it no longer
// needs it hands out by spent(), to be given back to their cameras. It holds at most kHeld frames of a
// camera.
class RigSync {
 public:
  static constexpr std::size_t kHeld = 4;
  static constexpr std::size_t kMostCameras = 16;

  RigSync(std::size_t cameras, const SyncSettings& settings);

  // A camera's next frame, which came at `now`.
  void offer(std::size_t camera, const CameraFrame& frame, std::chrono::nanoseconds now) noexcept;
  // The camera's stream is over and its frames are gone with it. `kept`: a copy of the one that was shown,
  // which is late from now on; without, the slate is shown. It is spent like any other frame.
  void lose(std::size_t camera, const CameraFrame* kept) noexcept;

  // Looks for a set newer than the one that is shown; true when any face has changed since the last call.
  bool choose(std::chrono::nanoseconds now) noexcept;
  const std::vector<SyncedFace>& faces() const { return faces_; }
  // The time of the set shown: that of its first frame. 0 before the first.
  std::chrono::nanoseconds captured_at() const { return set_at_; }

  // A frame that is no longer needed, until there is none.
  struct Spent {
    std::size_t camera = 0;
    CameraFrame frame;
  };
  std::optional<Spent> spent() noexcept;

  const SyncCounts& counts() const { return counts_; }
  SyncOffset offset(std::size_t camera) const;

 private:
  struct Held {
    CameraFrame frame;
    std::chrono::nanoseconds came_at{0};
  };
  struct OffsetFilter {
    void measure(std::chrono::nanoseconds at, std::chrono::nanoseconds apart) noexcept;
    bool begun = false;
    double offset = 0.0;  // nanoseconds
    double drift = 0.0;   // nanoseconds a nanosecond
    std::chrono::nanoseconds measured_at{0};
  };
  struct Queue {
    std::array<Held, kHeld> held;  // in the order they came
    std::size_t count = 0;
    bool shown = false;  // held[0] is in the set that is shown
    OffsetFilter clock;
  };
  struct Match;

  Match match(std::chrono::nanoseconds at, std::chrono::nanoseconds now) const noexcept;
  bool show_newest(std::chrono::nanoseconds now) noexcept;
  void show(const Match& match) noexcept;
  void drop(std::size_t camera, std::size_t count) noexcept;
  void measure_offsets() noexcept;

  SyncSettings settings_;
  std::vector<Queue> cameras_;
  std::vector<SyncedFace> faces_;
  std::vector<Spent> spent_;
  std::chrono::nanoseconds set_at_{0};
  SyncCounts counts_;
};

}  // namespace cupola
