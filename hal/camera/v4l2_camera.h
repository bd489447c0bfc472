// A camera through V4L2, the Linux kernel's video interface: memory-mapped streaming, one buffer at a time.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "hal/camera/camera.h"
#include "hal/camera/system_calls.h"
#include "hal/camera/v4l2_buffers.h"
#include "hal/camera/v4l2_format.h"
#include "hal/camera/v4l2_node.h"
#include "hal/time/clock.h"

namespace cupola {

class V4l2Camera final : public Camera {
 public:
  // Both are borrowed for the camera's life. The clock stamps frames of drivers that do not.
  V4l2Camera(SystemCalls& calls, Clock& clock) : calls_(calls), clock_(clock) {}
  ~V4l2Camera() override { stop(); }
  V4l2Camera(const V4l2Camera&) = delete;
  V4l2Camera& operator=(const V4l2Camera&) = delete;

  std::variant<CameraMode, CameraTrouble> start(const CameraSetup& setup) noexcept override;
  void stop() noexcept override;
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept override;
  void give_back(const CameraFrame& frame) noexcept override;
  int descriptor() const noexcept override { return node_.descriptor; }
  bool set_control(const CameraControl& control) noexcept override;

 private:
  std::optional<CameraTrouble> set_up(const CameraSetup& setup);
  std::optional<CameraTrouble> events() noexcept;
  void describe_frame(const V4l2Buffers::Filled& filled, CameraFrame& frame) const noexcept;
  std::chrono::nanoseconds time_of(const v4l2_buffer& buffer) const noexcept;

  SystemCalls& calls_;
  Clock& clock_;
  V4l2Node node_;
  V4l2Layout layout_;
  V4l2Buffers buffers_;
  bool streaming_ = false;
  bool tells_events_ = false;
  std::optional<CameraTrouble> loss_;
};

}  // namespace cupola
