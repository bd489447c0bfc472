// A trial of a rig's cameras: streams all of them for a while and measures what an operator asks first.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/camera_picture.h"
#include "hal/camera/camera_watch.h"
#include "hal/time/clock.h"

namespace cupola {

struct TrialPicture {
  std::chrono::nanoseconds at{0};
  GreyPicture grey;
};

struct TrialResult {
  CameraCounts counts;
  std::optional<CameraMode> mode;        // none: it never started
  std::optional<CameraTrouble> trouble;  // the last, unless it streams now and nothing was lost
  double rate = 0.0;                     // frames a second by their timestamps; 0 with fewer than two frames
  double jitter_ms = 0.0;     // standard deviation of the time between frames that follow each other
  double worst_gap_ms = 0.0;  // the longest time between two frames
  std::optional<PictureFacts> picture;  // of the last frame that was looked at: one in half a second
  // The first two of every half second of the clock, whatever the camera: of cameras in step, one of the two
  // is of the same instant. None of JPEG ones.
  std::vector<TrialPicture> pictures;
  // Against the first camera: median over its frames of (nearest frame of this one - it). None without frames
  // of both.
  std::optional<double> offset_ms;
  double offset_spread_ms = 0.0;  // between the largest and the smallest of these
};

// Streams for `time` of the clock; the watches stream on afterwards.
std::vector<TrialResult> try_cameras(std::span<CameraWatch* const> cameras, Clock& clock,
                                     std::chrono::nanoseconds time);

// What is wrong, in words; empty when nothing is. `wanted_rate` 0: any.
std::vector<std::string> complaints(const TrialResult& result, double wanted_rate);

}  // namespace cupola
