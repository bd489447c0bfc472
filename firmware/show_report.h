// Where a show stands, as its maker says it frame by frame.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "pipeline/source/exposure_drive.h"
#include "pipeline/source/face_streams.h"
#include "pipeline/warp/view_colour.h"

namespace cupola {

struct CameraReport {
  enum class Shown : std::uint8_t { kInStep, kLate, kSlate };
  Shown shown = Shown::kSlate;
  std::uint64_t frames = 0;
  std::uint64_t dropped = 0;
  std::uint64_t damaged = 0;
  std::uint64_t losses = 0;
  std::chrono::nanoseconds offset{0};  // of its clock against the first camera's
  double drift_ppm = 0.0;
  std::optional<ViewColour> colour = std::nullopt;  // where it is matched or locked
};

struct ExposureReport {
  Exposure told;            // all cameras
  double brightness = 0.0;  // the pictures' mean, 0 to 1
};

// Plain memory: copied from thread to thread.
struct ShowReport {
  static constexpr std::size_t kMostCameras = 16;

  std::size_t cue = 0;                                              // its place in the show, from 0
  std::chrono::nanoseconds position{0};                             // in the cue
  std::optional<std::chrono::nanoseconds> duration = std::nullopt;  // of the cue; none: it never ends
  bool waiting = false;                                             // for go, at the cue's end
  FileCounts files;                                                 // of all cues
  FileQueue queue;                                                  // of the cue shown
  std::array<char, 240> trouble{};  // why the last faces could not be had, cut; empty when they could
  std::size_t camera_count = 0;
  std::array<CameraReport, kMostCameras> cameras{};       // in the rig file's order
  std::optional<ExposureReport> exposure = std::nullopt;  // where all are exposed alike
};

}  // namespace cupola
