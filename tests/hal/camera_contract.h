// What every camera promises: the tests are in camera_contract.cpp. A program that has cameras instantiates
// CameraContract with their makers.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "hal/camera/camera_planes.h"
#include "hal/camera/fake_picture.h"
#include "tests/hal/camera_stage.h"
#include "tests/hal/camera_viewer.h"

namespace cupola {

class CameraContract : public testing::TestWithParam<CameraStageMaker> {
 protected:
  ~CameraContract() override { say_frames(GetParam().name, frames_); }

  CameraMode start(const CameraSetup& setup) {
    const auto started = camera_.start(setup);
    if (const CameraTrouble* trouble = std::get_if<CameraTrouble>(&started)) {
      ADD_FAILURE() << describe(*trouble);
      return {};
    }
    return std::get<CameraMode>(started);
  }
  // The next frame, within two seconds.
  std::optional<CameraFrame> next() {
    const std::chrono::nanoseconds end = clock_.now() + std::chrono::seconds(2);
    for (;;) {
      CameraFrame frame;
      CameraTrouble trouble;
      switch (camera_.poll(frame, trouble)) {
        case CameraPoll::kFrame:
          ++frames_;
          return frame;
        case CameraPoll::kLost:
          ADD_FAILURE() << describe(trouble);
          return std::nullopt;
        case CameraPoll::kNothing: {
          const std::array<int, 1> descriptors = {camera_.descriptor()};
          if (!clock_.wait(descriptors, end)) return std::nullopt;
          break;
        }
        case CameraPoll::kDamaged:
          break;
      }
    }
  }
  // Polls without waiting; true for a frame.
  bool poll(CameraFrame& frame) {
    CameraTrouble trouble;
    const CameraPoll polled = camera_.poll(frame, trouble);
    EXPECT_NE(polled, CameraPoll::kLost) << describe(trouble);
    return polled == CameraPoll::kFrame;
  }
  static std::uint64_t sum_of(const CameraFrame& frame) {
    std::uint64_t hash = 0xcbf29ce484222325U;
    for (const CameraPlane& plane : frame.planes) {
      for (std::size_t i = 0; i < plane.bytes; i += 61) hash = (hash ^ plane.data[i]) * 0x100000001b3U;
    }
    return hash;
  }
  // That a machine which is busy otherwise may miss.
  static std::uint32_t frames_late(const CameraMode& mode) {
    return static_cast<std::uint32_t>(GetParam().lateness / period(mode));
  }
  static std::chrono::nanoseconds period(const CameraMode& mode) {
    const double rate = mode.rate > 0.0 ? mode.rate : 25.0;  // it does not say: no slower than this
    return std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / rate));
  }

  std::unique_ptr<CameraStage> stage_ = GetParam().make();
  Clock& clock_ = stage_->clock();
  Camera& camera_ = stage_->camera();
  std::uint64_t frames_ = 0;
};

}  // namespace cupola
