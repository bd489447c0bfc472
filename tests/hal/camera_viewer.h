// Watches a camera as the player will and checks every frame: whole, in order, with sane times, and the
// picture that it says it is.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "hal/camera/camera_watch.h"
#include "tests/hal/camera_stage.h"

namespace cupola {

class CameraViewer {
 public:
  static constexpr std::chrono::nanoseconds kPatience = std::chrono::milliseconds(100);

  CameraViewer(CameraStage& stage, const CameraStageMaker& maker);
  CameraViewer(const CameraViewer&) = delete;
  CameraViewer& operator=(const CameraViewer&) = delete;

  // What was seen since it was last asked.
  struct Seen {
    std::uint64_t frames = 0;
    int losses = 0;
    int backs = 0;
    std::chrono::nanoseconds lost_at{0};   // when kLost was said last
    std::chrono::nanoseconds first_at{0};  // when the first frame of all of them was polled
    std::chrono::nanoseconds last_at{0};
  };
  // Polls once at least.
  Seen run(std::chrono::nanoseconds duration) { return watch_until(stage_.clock().now() + duration, false); }
  // No longer than until it has a frame.
  Seen run_until_frame(std::chrono::nanoseconds at_most) {
    return watch_until(stage_.clock().now() + at_most, true);
  }

  CameraWatch& watch() { return watch_; }
  std::uint64_t frames() const { return frames_; }

 private:
  Seen watch_until(std::chrono::nanoseconds end, bool one_frame);
  void check(const CameraFrame& frame);

  CameraStage& stage_;
  const CameraStageMaker& maker_;
  CameraWatch watch_;
  std::uint64_t frames_ = 0;
  std::optional<std::uint64_t> sequence_;
  std::optional<std::uint32_t> stamp_offset_;  // from the sequence to the picture's, within one run
  std::chrono::nanoseconds captured_at_ = std::chrono::nanoseconds::min();
};

// "vivid: 60 frames" on a line of its own, for those who read the log.
void say_frames(const std::string& who, std::uint64_t frames);
// All that were said so far.
std::uint64_t frames_said();

}  // namespace cupola
