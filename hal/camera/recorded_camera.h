// A camera that was recorded, as if live: says what it said then, at the same times.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>

#include "hal/camera/camera.h"
#include "hal/camera/recording_file.h"
#include "hal/time/clock.h"

namespace cupola {

// When the recordings of one rig began, on the clock of now: the first camera that is started sets it.
struct ReplayTime {
  std::optional<std::chrono::nanoseconds> begin;
};

// Each start answers as the next one in the recording did, whatever the setup asks; what was recorded before
// it and not polled is gone. When the recording ends the camera is lost for good (kMissing).
class RecordedCamera final : public Camera {
 public:
  // Throws as RecordingReader does. `clock` and `time` are borrowed for the camera's life.
  RecordedCamera(Clock& clock, ReplayTime& time, const std::filesystem::path& file);

  std::variant<CameraMode, CameraTrouble> start(const CameraSetup& setup) noexcept override;
  void stop() noexcept override;
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept override;
  void give_back(const CameraFrame&) noexcept override {}  // the file has a place for each
  int descriptor() const noexcept override { return running_ ? alarm_ : -1; }

  const RecordingReader& recording() const { return recording_; }
  // Goes to the start that the first frame came of: shows start cameras whole before they crop them. Before
  // the first start().
  void pass_over_empty_starts() noexcept;

 private:
  void wind_alarm() noexcept;

  Clock& clock_;
  ReplayTime& time_;
  RecordingReader recording_;
  int alarm_;
  bool running_ = false;
  std::optional<CameraTrouble> lost_;
  std::size_t next_ = 0;  // record
};

}  // namespace cupola
