// Fake cameras and V4L2 cameras on fake devices, held to what every camera promises.
// SPDX-License-Identifier: MIT
#include "tests/hal/camera_contract.h"

#include "hal/camera/mjpeg_camera.h"
#include "hal/camera/recording_camera.h"
#include "tests/frame/temporary_folder.h"
#include "tests/hal/camera_faults.h"

#ifdef CUPOLA_V4L2
#include "tests/hal/v4l2_stage.h"
#endif

namespace cupola {
namespace {

using namespace std::chrono_literals;
using F = CameraFault;

class FakeStage final : public CameraStage {
 public:
  explicit FakeStage(const FakeCameraDevice& device) : camera_(clock_, device) {}
  Clock& clock() override { return clock_; }
  Camera& camera() override { return camera_; }
  CameraSetup setup() override {
    CameraSetup setup;
    setup.device = "fake";
    setup.formats = {CameraFormat::kNv12, CameraFormat::kYuyv};
    setup.width = 64;
    setup.height = 48;
    setup.rate = 60.0;
    return setup;
  }
  void begin_fault(CameraFault fault, std::int64_t amount) override { camera_.begin_fault(fault, amount); }
  void end_faults() override { camera_.end_faults(); }

 private:
  FakeClock clock_;
  FakeCamera camera_;
};

// A camera of JPEG pictures, decoded as they are polled.
class MjpegStage final : public CameraStage {
 public:
  explicit MjpegStage(const FakeCameraDevice& device)
      : made_(std::make_unique<FakeCamera>(clock_, device)),
        device_(*made_),
        camera_(std::move(made_), clock_, MjpegCamera::Decoding::kInPoll) {}
  Clock& clock() override { return clock_; }
  Camera& camera() override { return camera_; }
  CameraSetup setup() override {
    CameraSetup setup;
    setup.formats = {CameraFormat::kMjpeg, CameraFormat::kGrey};  // as it is asked, and as it is then
    setup.width = 64;
    setup.height = 48;
    setup.rate = 60.0;
    return setup;
  }
  void begin_fault(CameraFault fault, std::int64_t amount) override { device_.begin_fault(fault, amount); }
  void end_faults() override { device_.end_faults(); }

 private:
  FakeClock clock_;
  std::unique_ptr<FakeCamera> made_;
  FakeCamera& device_;
  MjpegCamera camera_;
};

// A camera that is recorded meanwhile.
template <CameraRecorder::Writing writing>
class RecordedStage final : public CameraStage {
 public:
  explicit RecordedStage(const FakeCameraDevice& device)
      : made_(std::make_unique<FakeCamera>(clock_, device)),
        device_(*made_),
        camera_(std::move(made_), clock_, 0ns,
                std::make_unique<CameraRecorder>(folder_ / "camera", writing)) {}
  Clock& clock() override { return clock_; }
  Camera& camera() override { return camera_; }
  CameraSetup setup() override {
    CameraSetup setup;
    setup.formats = {CameraFormat::kNv12, CameraFormat::kYuyv};
    setup.width = 64;
    setup.height = 48;
    setup.rate = 60.0;
    return setup;
  }
  void begin_fault(CameraFault fault, std::int64_t amount) override { device_.begin_fault(fault, amount); }
  void end_faults() override { device_.end_faults(); }

 private:
  TemporaryFolder folder_;
  FakeClock clock_;
  std::unique_ptr<FakeCamera> made_;
  FakeCamera& device_;
  RecordingCamera camera_;
};

FakeCameraDevice jpeg_device() {
  FakeCameraDevice device;
  device.formats = {CameraFormat::kMjpeg};
  return device;
}
FakeCameraDevice device() {
  FakeCameraDevice device;
  device.number = 3;
  return device;
}
// As cameras are: the counter wraps soon, frames are late by a millisecond at most, and take two to arrive.
FakeCameraDevice unsteady_device() {
  FakeCameraDevice device;
  device.number = 200;
  device.formats = {CameraFormat::kGrey, CameraFormat::kNv12};
  device.jitter = 900us;
  device.latency = 2ms;
  device.drift_ppm = 40.0;
  device.first_sequence = 0xfffffff0U;
  return device;
}

const std::vector<CameraFault> kAllFaults = {
    F::kDropped,   F::kDamaged,     F::kSilent,      F::kUnplugged, F::kNoSignal,     F::kStartFails,
    F::kWrongSize, F::kWrongFormat, F::kWrongStride, F::kShort,     F::kTimestampStep};
const std::vector<CameraStageMaker> kFakes = {
    {"Fake", [] { return std::unique_ptr<CameraStage>(std::make_unique<FakeStage>(device())); }, 0ns, true,
     kAllFaults},
    {"UnsteadyFake",
     [] { return std::unique_ptr<CameraStage>(std::make_unique<FakeStage>(unsteady_device())); }, 3ms, true,
     kAllFaults},
    {"Recorded",
     [] {
       return std::unique_ptr<CameraStage>(
           std::make_unique<RecordedStage<CameraRecorder::Writing::kAtOnce>>(device()));
     },
     0ns, true, kAllFaults},
    {"RecordedOnAThread",
     [] {
       return std::unique_ptr<CameraStage>(
           std::make_unique<RecordedStage<CameraRecorder::Writing::kOnAThread>>(device()));
     },
     0ns, true, kAllFaults},
    // The decoder finds out by itself what is no picture: cut ones are damaged. While all pictures are lent,
    // some wait in the device.
    {"Mjpeg",
     [] { return std::unique_ptr<CameraStage>(std::make_unique<MjpegStage>(jpeg_device())); },
     0ns,
     false,
     {F::kDropped, F::kDamaged, F::kSilent, F::kUnplugged, F::kNoSignal, F::kStartFails, F::kShort,
      F::kTimestampStep},
     10s,
     false},
};

INSTANTIATE_TEST_SUITE_P(Fakes, CameraContract, testing::ValuesIn(kFakes),
                         [](const auto& maker) { return std::string(maker.param.name); });
INSTANTIATE_TEST_SUITE_P(Fakes, CameraFaults, testing::ValuesIn(camera_fault_cases(kFakes)), name_of_case);

#ifdef CUPOLA_V4L2
template <__u32 fourcc>
FakeV4l2Device sensor() {
  FakeV4l2Device device;
  device.number = 7;
  device.fourccs = {V4L2_PIX_FMT_BGR24, fourcc};
  return device;
}
template <__u32 fourcc>
FakeV4l2Device multi_planar() {
  FakeV4l2Device device = sensor<fourcc>();
  device.multi_planar = true;
  device.padding = 32;
  device.header = 24;
  device.first_sequence = 0xffffffe0U;
  return device;
}
FakeV4l2Device hdmi() {
  FakeV4l2Device device = sensor<V4L2_PIX_FMT_UYVY>();
  device.hdmi = true;
  device.padding = 64;
  device.can_export = false;
  return device;
}

const std::vector<CameraStageMaker> kV4l2 = {
    v4l2_stage<sensor<V4L2_PIX_FMT_YUYV>>("Yuyv"),
    v4l2_stage<sensor<V4L2_PIX_FMT_MJPEG>>("Mjpeg"),
    v4l2_stage<sensor<V4L2_PIX_FMT_YUV420>>("I420"),
    v4l2_stage<multi_planar<V4L2_PIX_FMT_NV12>>("MultiPlanarNv12"),
    v4l2_stage<multi_planar<V4L2_PIX_FMT_NV12M>>("MultiPlanarNv12InTwo"),
    v4l2_stage<multi_planar<V4L2_PIX_FMT_YUV420M>>("MultiPlanarI420InThree"),
    v4l2_stage<hdmi>("Hdmi"),
};
INSTANTIATE_TEST_SUITE_P(V4l2, CameraContract, testing::ValuesIn(kV4l2),
                         [](const auto& maker) { return std::string(maker.param.name); });
INSTANTIATE_TEST_SUITE_P(V4l2, CameraFaults, testing::ValuesIn(camera_fault_cases(kV4l2)), name_of_case);
#endif

}  // namespace
}  // namespace cupola
