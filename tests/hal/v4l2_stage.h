// A V4L2 camera on one FakeV4l2 device, which must have no complaints in the end.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "hal/camera/v4l2_camera.h"
#include "tests/hal/camera_stage.h"
#include "tests/hal/fake_v4l2.h"
#include "tests/hal/fake_v4l2_node.h"

namespace cupola {

class V4l2Stage final : public CameraStage {
 public:
  explicit V4l2Stage(const FakeV4l2Device& device) : node_(calls_.add(device)) {}
  ~V4l2Stage() override {
    camera_.stop();
    EXPECT_EQ(calls_.complaints(), "");
  }
  Clock& clock() override { return clock_; }
  Camera& camera() override { return camera_; }
  CameraSetup setup() override {
    CameraSetup setup;
    setup.device = node_.device().bus;
    setup.formats = {CameraFormat::kMjpeg, CameraFormat::kNv12, CameraFormat::kI420, CameraFormat::kYuyv,
                     CameraFormat::kUyvy};
    setup.width = node_.device().width;
    setup.height = node_.device().height;
    setup.rate = 60.0;
    return setup;
  }
  void begin_fault(CameraFault fault, std::int64_t amount) override { node_.begin_fault(fault, amount); }
  void end_faults() override { node_.end_faults(); }

  FakeV4l2& calls() { return calls_; }
  FakeV4l2Node& node() { return node_; }

 private:
  FakeClock clock_;
  FakeV4l2 calls_{clock_};
  FakeV4l2Node& node_;
  V4l2Camera camera_{calls_, clock_};
};

template <FakeV4l2Device (*device)()>
CameraStageMaker v4l2_stage(const char* name) {
  using F = CameraFault;
  std::vector<F> faults = {F::kDropped,    F::kDamaged,   F::kSilent,      F::kUnplugged, F::kNoSignal,
                           F::kStartFails, F::kWrongSize, F::kWrongFormat, F::kShort,     F::kTimestampStep};
  const std::vector<__u32> fourccs = device().fourccs;
  // A compressed picture has no rows to be too short, and none of half its bytes is told from a small one.
  if (fourccs.back() == V4L2_PIX_FMT_MJPEG) {
    std::erase(faults, F::kShort);
  } else {
    faults.push_back(F::kWrongStride);
  }
  return {name, [] { return std::unique_ptr<CameraStage>(std::make_unique<V4l2Stage>(device())); },
          std::chrono::nanoseconds(0), true, faults};
}

}  // namespace cupola
