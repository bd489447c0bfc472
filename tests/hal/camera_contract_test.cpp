// The cameras of memory, held to what every camera promises.
// SPDX-License-Identifier: MIT
#include "tests/hal/camera_contract.h"

#include "tests/hal/camera_faults.h"

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
};

INSTANTIATE_TEST_SUITE_P(Fakes, CameraContract, testing::ValuesIn(kFakes),
                         [](const auto& maker) { return std::string(maker.param.name); });
INSTANTIATE_TEST_SUITE_P(Fakes, CameraFaults, testing::ValuesIn(camera_fault_cases(kFakes)), name_of_case);

}  // namespace
}  // namespace cupola
