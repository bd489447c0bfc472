// Any camera, recorded while it streams: what it says goes to a file, with the time that it was said.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "hal/camera/camera.h"
#include "hal/camera/camera_recorder.h"
#include "hal/time/clock.h"

namespace cupola {

class RecordingCamera final : public Camera {
 public:
  // Times count from `begin`: the same for all cameras of a rig. `clock` is borrowed for the camera's life.
  RecordingCamera(std::unique_ptr<Camera> device, Clock& clock, std::chrono::nanoseconds begin,
                  std::unique_ptr<CameraRecorder> recorder);
  ~RecordingCamera() override;

  std::variant<CameraMode, CameraTrouble> start(const CameraSetup& setup) noexcept override;
  void stop() noexcept override;
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept override;
  void give_back(const CameraFrame& frame) noexcept override;
  int descriptor() const noexcept override { return device_->descriptor(); }
  bool set_control(const CameraControl& control) noexcept override { return device_->set_control(control); }

  RecorderCounts counts() const noexcept { return recorder_->counts(); }

 private:
  CameraRecord record(RecordKind kind) const noexcept;
  void return_copied() noexcept;

  std::unique_ptr<Camera> device_;
  Clock& clock_;
  std::chrono::nanoseconds begin_;
  std::unique_ptr<CameraRecorder> recorder_;
  std::optional<CameraFrame> withheld_;  // given back while it was copied: the device has it a little later
};

}  // namespace cupola
