// A camera that sends one picture over and over, when the device in it has a frame.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <utility>

#include "hal/camera/camera.h"
#include "pipeline/frame/native_image.h"

namespace cupola::test {

// `device` sends frames of the picture's format and size, whole; and nobody sets controls.
class PostcardCamera final : public Camera {
 public:
  PostcardCamera(std::unique_ptr<Camera> device, NativeBuffer picture)
      : device_(std::move(device)), picture_(std::move(picture)) {}

  std::variant<CameraMode, CameraTrouble> start(const CameraSetup& setup) noexcept override {
    return device_->start(setup);
  }
  void stop() noexcept override { device_->stop(); }
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept override {
    const CameraPoll polled = device_->poll(frame, trouble);
    if (polled != CameraPoll::kFrame) return polled;
    for (std::size_t p = 0; p < plane_count(picture_.pixels().layout); ++p) {
      const auto& [data, stride] = picture_.pixels().planes[p];
      const int rows = plane_bytes(picture_.pixels().layout, picture_.pixels().size, p).height;
      frame.planes[p] = {data, stride, static_cast<std::size_t>(stride * rows), -1, 0};
    }
    return polled;
  }
  void give_back(const CameraFrame& frame) noexcept override { device_->give_back(frame); }
  int descriptor() const noexcept override { return device_->descriptor(); }

 private:
  std::unique_ptr<Camera> device_;
  NativeBuffer picture_;
};

}  // namespace cupola::test
