// A camera of memory in real time: prepared pictures at an even rate, each late by a jitter, in step with all
// others of that rate; for timing what comes after cameras.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "hal/camera/camera.h"
#include "hal/time/clock.h"

namespace cupola {

struct PacedCameraDevice {
  int number = 0;
  CameraFormat format = CameraFormat::kNv12;
  int width = 1280;
  int height = 720;
  double rate = 60.0;
  std::chrono::nanoseconds jitter{0};   // at most
  std::chrono::nanoseconds latency{0};  // from a picture's timestamp until it can be polled
};

class PacedCamera final : public Camera {
 public:
  // `clock` must be the machine's own; it is borrowed for the camera's life. Throws std::runtime_error where
  // the system has no timer left.
  PacedCamera(Clock& clock, const PacedCameraDevice& device);
  ~PacedCamera() override;

  std::variant<CameraMode, CameraTrouble> start(const CameraSetup& setup) noexcept override;
  void stop() noexcept override;
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept override;
  void give_back(const CameraFrame& frame) noexcept override;
  int descriptor() const noexcept override { return timer_; }

 private:
  std::chrono::nanoseconds captured_at(std::uint64_t frame) const noexcept;
  void wind_timer() noexcept;

  Clock& clock_;
  PacedCameraDevice device_;
  int timer_;
  bool running_ = false;
  std::vector<std::vector<std::uint8_t>> pictures_;  // lent one after the other, whoever has the others
  std::vector<CameraFrame> frames_;                  // of them
  std::vector<bool> lent_;
  std::chrono::nanoseconds started_at_{0};
  std::uint64_t next_ = 0;
};

}  // namespace cupola
