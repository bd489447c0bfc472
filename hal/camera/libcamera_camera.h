// A camera of libcamera: CSI sensors with their image processors, and whatever else it drives.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "hal/camera/camera.h"
#include "hal/camera/libcamera_system.h"
#include "hal/time/clock.h"

namespace cupola {

class LibcameraStream;

// Named as find_camera() says. libcamera knows no signal and no trigger; formats, controls and crop are what
// its pipeline has for the sensor. A thread of its own hands buffers back, because that allocates in
// libcamera.
class LibcameraCamera final : public Camera {
 public:
  // Both are borrowed for the camera's life.
  LibcameraCamera(LibcameraSystem& system, Clock& clock);
  ~LibcameraCamera() override;

  std::variant<CameraMode, CameraTrouble> start(const CameraSetup& setup) noexcept override;
  void stop() noexcept override;
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept override;
  void give_back(const CameraFrame& frame) noexcept override;
  int descriptor() const noexcept override;
  bool set_control(const CameraControl& control) noexcept override;

 private:
  LibcameraSystem& system_;
  Clock& clock_;
  std::unique_ptr<LibcameraStream> stream_;  // from start to stop
};

}  // namespace cupola
