// One stream after the other.
// SPDX-License-Identifier: MIT
#include "hal/camera/libcamera_camera.h"

#include <exception>

#include "hal/camera/libcamera_stream.h"

namespace cupola {

LibcameraCamera::LibcameraCamera(LibcameraSystem& system, Clock& clock) : system_(system), clock_(clock) {}

LibcameraCamera::~LibcameraCamera() = default;

std::variant<CameraMode, CameraTrouble> LibcameraCamera::start(const CameraSetup& setup) noexcept {
  stop();
  try {
    auto stream = std::make_unique<LibcameraStream>(system_, clock_);
    const auto answer = stream->open(setup);
    if (std::holds_alternative<CameraMode>(answer)) stream_ = std::move(stream);
    return answer;
  } catch (const std::exception&) {
    return CameraTrouble{CameraCause::kFailed, "out of memory or threads", 0};
  }
}

void LibcameraCamera::stop() noexcept {
  stream_.reset();
}

CameraPoll LibcameraCamera::poll(CameraFrame& frame, CameraTrouble& trouble) noexcept {
  return stream_ ? stream_->poll(frame, trouble) : CameraPoll::kNothing;
}

void LibcameraCamera::give_back(const CameraFrame& frame) noexcept {
  if (stream_) stream_->give_back(frame.buffer);
}

bool LibcameraCamera::set_control(const CameraControl& control) noexcept {
  return stream_ && stream_->set_control(control);
}

int LibcameraCamera::descriptor() const noexcept {
  return stream_ ? stream_->descriptor() : -1;
}

}  // namespace cupola
