// Every system call that a V4L2 camera makes fails once, or from then on: at its first call, its second, and
// so on until a run comes through without reaching the failure.
// SPDX-License-Identifier: MIT
#include <cerrno>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/hal/camera_viewer.h"
#include "tests/hal/v4l2_stage.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

struct FailingCall {
  const char* name;
  unsigned long call;
  bool needed;  // a stream cannot begin, or go on, when it fails
};

const std::vector<FailingCall> kCalls = {
    {"open", FakeV4l2::kOpen, true},
    {"close", FakeV4l2::kClose, false},
    {"mmap", FakeV4l2::kMmap, true},
    {"munmap", FakeV4l2::kMunmap, false},
    {"QUERYCAP", VIDIOC_QUERYCAP, true},
    {"SUBSCRIBE_EVENT", VIDIOC_SUBSCRIBE_EVENT, false},
    {"G_INPUT", VIDIOC_G_INPUT, false},
    {"ENUMINPUT", VIDIOC_ENUMINPUT, false},
    {"QUERY_DV_TIMINGS", VIDIOC_QUERY_DV_TIMINGS, true},
    {"S_DV_TIMINGS", VIDIOC_S_DV_TIMINGS, true},
    {"ENUM_FMT", VIDIOC_ENUM_FMT, true},
    {"G_FMT", VIDIOC_G_FMT, true},
    {"S_FMT", VIDIOC_S_FMT, true},
    {"G_SELECTION", VIDIOC_G_SELECTION, false},
    {"S_SELECTION", VIDIOC_S_SELECTION, false},
    {"G_PARM", VIDIOC_G_PARM, false},
    {"S_PARM", VIDIOC_S_PARM, false},
    {"QUERY_EXT_CTRL", VIDIOC_QUERY_EXT_CTRL, true},
    {"S_EXT_CTRLS", VIDIOC_S_EXT_CTRLS, true},
    {"REQBUFS", VIDIOC_REQBUFS, true},
    {"QUERYBUF", VIDIOC_QUERYBUF, true},
    {"EXPBUF", VIDIOC_EXPBUF, false},
    {"QBUF", VIDIOC_QBUF, true},
    {"STREAMON", VIDIOC_STREAMON, true},
    {"DQBUF", VIDIOC_DQBUF, true},
    {"DQEVENT", VIDIOC_DQEVENT, true},
    {"STREAMOFF", VIDIOC_STREAMOFF, false},
};

FakeV4l2Device sensor() {
  FakeV4l2Device device;
  device.controls = {
      {V4L2_CID_EXPOSURE_ABSOLUTE, "Exposure Time, Absolute", V4L2_CTRL_TYPE_INTEGER, 1, 5000, 1, {}}};
  return device;
}
FakeV4l2Device hdmi() {
  FakeV4l2Device device = sensor();
  device.hdmi = true;
  device.multi_planar = true;
  device.fourccs = {V4L2_PIX_FMT_NV12M};
  return device;
}

class V4l2Failures : public testing::TestWithParam<FailingCall> {
 protected:
  ~V4l2Failures() override { say_frames(std::string("V4l2 with failing ") + GetParam().name, frames_); }

  // False when the run did not reach the failure.
  template <FakeV4l2Device (*device)()>
  bool run(std::uint64_t nth, int error, bool for_good) {
    SCOPED_TRACE(std::to_string(nth) + (for_good ? " and on: " : ": ") + std::to_string(error));
    V4l2Stage stage(device());
    const CameraStageMaker maker = v4l2_stage<device>("V4l2");
    CameraSetup setup = stage.setup();
    setup.controls = {{"exposure", 10000.0}};
    CameraViewer viewer(stage, maker);
    viewer.watch().set_setup(setup);
    stage.calls().fail(GetParam().call, nth, error, for_good);
    // Two runs, so that everything that ends and begins again is reached.
    viewer.run(120ms);
    viewer.watch().stop();
    const CameraViewer::Seen second = viewer.run(400ms);
    const CameraCounts counts = viewer.watch().counts();
    const bool reached = stage.calls().has_failed();
    const std::uint64_t times = counts.losses + counts.failed_starts;
    const bool flows = viewer.watch().state() == CameraState::kStreaming;
    if (flows) {
      EXPECT_GT(second.last_at, stage.clock().now() - CameraViewer::kPatience);
    } else {
      EXPECT_GT(times, 0U);
    }
    if (!reached || (!for_good && !GetParam().needed)) {
      EXPECT_EQ(times, 0U);
      EXPECT_GE(viewer.frames(), 28U);
    }
    // What ends a stream calls REQBUFS too, and does without.
    const bool must_show = reached && GetParam().needed && GetParam().call != VIDIOC_REQBUFS;
    EXPECT_GE(times, must_show ? 1U : 0U);
    if (!for_good) {
      EXPECT_LE(times, 1U) << "counted once";
      EXPECT_GE(viewer.frames(), 25U);
      EXPECT_TRUE(flows);
    }
    const nanoseconds healed = stage.clock().now();
    stage.calls().heal();
    const CameraViewer::Seen after = viewer.run(200ms);
    EXPECT_GE(after.frames, 10U);
    EXPECT_LE(after.first_at - healed, 2 * nanoseconds(16'666'667));
    EXPECT_EQ(viewer.watch().counts().losses, counts.losses);
    frames_ += viewer.frames();
    return reached;
  }

  template <FakeV4l2Device (*device)()>
  void run_all() {
    for (const int error : {EIO, ENODEV}) {
      for (const bool for_good : {false, true}) {
        std::uint64_t nth = 1;
        while (run<device>(nth, error, for_good) && !HasFailure()) ++nth;
        EXPECT_LT(nth, 200U);
      }
    }
  }

  std::uint64_t frames_ = 0;
};

TEST_P(V4l2Failures, AreSurvivedOnASensor) {
  run_all<sensor>();
}

TEST_P(V4l2Failures, AreSurvivedOnAMultiPlanarHdmiInput) {
  run_all<hdmi>();
}

TEST_P(V4l2Failures, ByASignalGoUnnoticed) {
  if (GetParam().call <= FakeV4l2::kMunmap) return;  // only open() can be interrupted, and has its own test
  for (std::uint64_t nth = 1; nth < 50; ++nth) {
    V4l2Stage stage(hdmi());
    const CameraStageMaker maker = v4l2_stage<hdmi>("V4l2");
    CameraViewer viewer(stage, maker);
    stage.calls().fail(GetParam().call, nth, EINTR, false);
    EXPECT_GE(viewer.run(400ms).frames, 22U);
    EXPECT_EQ(viewer.watch().counts().starts, 1U);
    EXPECT_EQ(viewer.watch().counts().failed_starts, 0U);
    frames_ += viewer.frames();
  }
}

INSTANTIATE_TEST_SUITE_P(All, V4l2Failures, testing::ValuesIn(kCalls),
                         [](const auto& call) { return std::string(call.param.name); });

}  // namespace
}  // namespace cupola
