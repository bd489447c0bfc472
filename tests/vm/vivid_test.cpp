// V4L2 cameras on the kernel's vivid driver: four HDMI inputs at 1280 x 720 and 60 Hz, with the faults that
// it can do. Inside a virtual machine, as root.
// SPDX-License-Identifier: MIT
#include <array>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "hal/camera/v4l2_camera.h"
#include "hal/camera/v4l2_devices.h"
#include "tests/hal/camera_contract.h"
#include "tests/hal/camera_faults.h"
#include "tests/vm/vivid_controls.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr nanoseconds kLateness = 300ms;  // of a machine that does other things too

// All four devices at once: really gone, and really new.
void plug(bool in) {
  std::ofstream(std::string("/sys/bus/platform/drivers/vivid/") + (in ? "bind" : "unbind"))
      << "vivid.0" << std::flush;
}

class VividStage final : public CameraStage {
 public:
  VividStage(int number, CameraFormat format) : number_(number), format_(format) {
    if (std::holds_alternative<CameraTrouble>(open_v4l2_device_and_close())) plug(true);
    end_faults();
  }
  ~VividStage() override {
    camera_.stop();
    end_faults();
  }
  Clock& clock() override { return clock_; }
  Camera& camera() override { return camera_; }
  CameraSetup setup() override {
    CameraSetup setup;
    setup.device = vivid_bus(number_);
    setup.formats = {format_};
    setup.width = 1280;
    setup.height = 720;
    setup.rate = 60.0;
    return setup;
  }
  void begin_fault(CameraFault fault, std::int64_t amount) override {
    switch (fault) {
      case CameraFault::kDropped:
        return set("percentage_of_dropped_buffers", static_cast<double>(amount));
      case CameraFault::kNoSignal:
        return set("dv_timings_signal_mode", 1.0);
      case CameraFault::kUnplugged:
        plug(false);
        unplugged_ = true;
        return;
      case CameraFault::kTimestampStep:
        return set("wrap_timestamp", static_cast<double>(amount));
      default:
        ADD_FAILURE() << "vivid cannot do this";
    }
  }
  void end_faults() override {
    if (std::exchange(unplugged_, false)) plug(true);
    set("percentage_of_dropped_buffers", 0.0);
    set("dv_timings_signal_mode", 0.0);
    set("wrap_timestamp", 0.0);
    set("wrap_sequence_number", 0.0);
  }
  void set(const char* control, double value) { set_vivid(number_, control, value); }

 private:
  std::variant<V4l2Node, CameraTrouble> open_v4l2_device_and_close() {
    auto opened = open_v4l2_device(calls_, vivid_bus(number_));
    if (const V4l2Node* node = std::get_if<V4l2Node>(&opened)) calls_.close(node->descriptor);
    return opened;
  }

  int number_;
  CameraFormat format_;
  bool unplugged_ = false;
  MonotonicClock clock_;
  LinuxCalls calls_;
  V4l2Camera camera_{calls_, clock_};
};

template <int number, CameraFormat format>
std::unique_ptr<CameraStage> make_stage() {
  return std::make_unique<VividStage>(number, format);
}

const std::vector<CameraFault> kFaults = {CameraFault::kDropped, CameraFault::kNoSignal,
                                          CameraFault::kUnplugged};
const std::vector<CameraStageMaker> kStages = {
    {"Yuyv", make_stage<0, CameraFormat::kYuyv>, kLateness, false, kFaults, 5s},
    {"Nv12", make_stage<1, CameraFormat::kNv12>, kLateness, false, kFaults},
    {"Rgb24", make_stage<2, CameraFormat::kRgb24>, kLateness, false, kFaults},
    {"I420", make_stage<3, CameraFormat::kI420>, kLateness, false, kFaults},
    {"I422", make_stage<3, CameraFormat::kI422>, kLateness, false, kFaults},
};
INSTANTIATE_TEST_SUITE_P(Vivid, CameraContract, testing::ValuesIn(kStages),
                         [](const auto& maker) { return std::string(maker.param.name); });
// One camera is enough: the driver's faults know no formats, and these take their time.
INSTANTIATE_TEST_SUITE_P(Vivid, CameraFaults,
                         testing::ValuesIn(camera_fault_cases(std::vector<CameraStageMaker>{kStages[0]})),
                         name_of_case);

class VividFaults : public testing::Test {
 protected:
  ~VividFaults() override { say_frames("vivid with a fault", viewer_.frames()); }
  const CameraCounts& counts() { return viewer_.watch().counts(); }
  void expect_one_loss_and_return(CameraCause cause) {
    const CameraViewer::Seen seen = viewer_.run(1s);
    EXPECT_EQ(seen.losses, 1);
    EXPECT_EQ(seen.backs, 1);
    EXPECT_GE(seen.frames, 40U);
    EXPECT_EQ(counts().losses, 1U);
    EXPECT_EQ(counts().of(cause), 1U);
    EXPECT_EQ(viewer_.watch().state(), CameraState::kStreaming);
  }

  VividStage stage_{0, CameraFormat::kYuyv};
  CameraViewer viewer_{stage_, kStages[0]};
};

TEST_F(VividFaults, ErrorFlagsAreCountedOneByOne) {
  viewer_.run(500ms);
  for (std::uint64_t i = 1; i <= 20; ++i) {
    stage_.set("inject_v4l2_buf_flag_error", 1.0);
    const CameraViewer::Seen seen = viewer_.run(100ms);
    EXPECT_EQ(counts().damaged, i);
    EXPECT_GE(seen.frames, 1U);
  }
  EXPECT_EQ(counts().losses, 0U);
}

TEST_F(VividFaults, AFatalErrorIsALossAndOverSoon) {
  viewer_.run(500ms);
  stage_.set("inject_fatal_streaming_error", 1.0);
  expect_one_loss_and_return(CameraCause::kFailed);
}

TEST_F(VividFaults, ADisconnectIsALossAndOverSoon) {
  viewer_.run(500ms);
  stage_.set("disconnect", 1.0);
  expect_one_loss_and_return(CameraCause::kMissing);
}

TEST_F(VividFaults, AQueueErrorIsALossAndOverSoon) {
  viewer_.run(500ms);
  stage_.set("inject_vidioc_qbuf_error", 1.0);
  expect_one_loss_and_return(CameraCause::kFailed);
}

TEST_F(VividFaults, ErrorsAtTheStartCostOneAttempt) {
  std::uint64_t failed = 0;
  for (const char* error :
       {"inject_vidioc_reqbufs_error", "inject_vidioc_qbuf_error", "inject_vidioc_streamon_error"}) {
    SCOPED_TRACE(error);
    viewer_.run(300ms);
    viewer_.watch().stop();
    stage_.set(error, 1.0);
    const nanoseconds begun = stage_.clock().now();
    const CameraViewer::Seen seen = viewer_.run(500ms);
    EXPECT_EQ(seen.losses, 1) << "told, as the camera did not come";
    EXPECT_EQ(counts().failed_starts, ++failed);
    EXPECT_GT(seen.frames, 5U);
    EXPECT_LE(seen.first_at - begun, 3 * 17ms + kLateness);
  }
}

TEST_F(VividFaults, WrongSignalsAreNoSignal) {
  viewer_.run(300ms);
  for (const double mode : {1.0, 2.0, 3.0}) {  // none, no lock, out of range
    stage_.set("dv_timings_signal_mode", mode);
    EXPECT_EQ(viewer_.run(300ms).losses, 1);
    EXPECT_EQ(viewer_.watch().trouble().cause, CameraCause::kNoSignal) << mode;
    stage_.set("dv_timings_signal_mode", 0.0);
    EXPECT_GT(viewer_.run(300ms).frames, 5U) << mode;
  }
  EXPECT_EQ(counts().of(CameraCause::kNoSignal), 3U);
}

TEST_F(VividFaults, WrappedSequencesGoOn) {
  stage_.set("wrap_sequence_number", 1.0);
  const CameraViewer::Seen seen = viewer_.run(4s);  // wraps at the 129th frame
  EXPECT_GE(seen.frames, 200U);
  EXPECT_LE(counts().dropped, 40U);
  EXPECT_EQ(counts().losses, 0U);
}

TEST_F(VividFaults, WrappedTimesAreOneClockStep) {
  std::uint64_t steps = 0;
  for (const double wrap : {1.0, 2.0}) {  // 64 bits of nanoseconds, 32 bits of seconds
    stage_.set("wrap_timestamp", wrap);
    const CameraViewer::Seen seen = viewer_.run(17s);  // wraps after sixteen
    EXPECT_GE(seen.frames, 700U);
    EXPECT_EQ(counts().clock_steps, ++steps) << wrap;
    viewer_.watch().stop();
  }
  EXPECT_EQ(counts().losses, 0U);
}

// The first frame of a stream with that crop, its luma as one row after the other.
struct Luma {
  CameraMode mode;
  std::vector<std::uint8_t> texels;
};
Luma first_luma(VividStage& stage, const CameraArea& crop) {
  Luma luma;
  CameraSetup setup = stage.setup();
  setup.crop = crop;
  const auto started = stage.camera().start(setup);
  const CameraMode* mode = std::get_if<CameraMode>(&started);
  if (!mode) return luma;
  luma.mode = *mode;
  CameraFrame frame;
  CameraTrouble trouble;
  for (int i = 0; i < 100 && stage.camera().poll(frame, trouble) != CameraPoll::kFrame; ++i) {
    stage.clock().sleep_until(stage.clock().now() + 20ms);
  }
  if (!frame.planes[0].data) return luma;
  for (int y = 0; y < frame.height; ++y) {
    const std::uint8_t* row = frame.planes[0].data + y * frame.planes[0].stride;
    luma.texels.insert(luma.texels.end(), row, row + frame.width);
  }
  return luma;
}

TEST(VividCameras, CropTexelOnTexel) {
  VividStage stage(1, CameraFormat::kNv12);
  stage.set("osd_text_mode", 2.0);  // no clock in the picture
  stage.set("test_pattern", 12.0);  // 1 x 1 chequers of red and blue: a texel off would show
  const Luma whole = first_luma(stage, {});
  const Luma part = first_luma(stage, {320, 100, 640, 400});
  stage.set("osd_text_mode", 0.0);
  stage.set("test_pattern", 0.0);
  ASSERT_EQ(whole.texels.size(), 1280U * 720U);
  ASSERT_EQ(part.mode.crop, (CameraArea{320, 100, 640, 400}));
  ASSERT_EQ(part.mode.width, 640);
  ASSERT_EQ(part.texels.size(), 640U * 400U);
  long wrong = 0;
  for (std::size_t y = 0; y < 400; ++y) {
    for (std::size_t x = 0; x < 640; ++x) {
      wrong += part.texels[y * 640 + x] != whole.texels[(y + 100) * 1280 + x + 320];
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_NE(part.texels[0], part.texels[1]) << "the pattern has texels to tell apart";
}

TEST(VividCameras, StreamFourAtOnce) {
  MonotonicClock clock;
  std::vector<std::unique_ptr<VividStage>> stages;
  std::vector<std::unique_ptr<CameraWatch>> watches;
  constexpr std::array<CameraFormat, 4> kFormats = {CameraFormat::kYuyv, CameraFormat::kNv12,
                                                    CameraFormat::kRgb24, CameraFormat::kYuyv};
  for (int i = 0; i < 4; ++i) {
    stages.push_back(std::make_unique<VividStage>(i, kFormats[static_cast<std::size_t>(i)]));
    watches.push_back(
        std::make_unique<CameraWatch>(stages.back()->camera(), stages.back()->setup(), clock, 250ms));
  }
  const nanoseconds end = clock.now() + 5s;
  std::array<int, 4> descriptors{};
  while (clock.now() < end) {
    nanoseconds deadline = end;
    for (std::size_t i = 0; i < 4; ++i) {
      CameraFrame frame;
      CameraWatch::Poll polled{};
      while ((polled = watches[i]->poll(frame)) != CameraWatch::Poll::kNothing) {
        if (polled == CameraWatch::Poll::kFrame) watches[i]->give_back(frame);
      }
      descriptors[i] = watches[i]->descriptor();
      deadline = std::min(deadline, watches[i]->deadline());
    }
    clock.wait(descriptors, deadline);
  }
  std::uint64_t frames = 0;
  for (const auto& watch : watches) {
    frames += watch->counts().frames;
    EXPECT_EQ(watch->counts().losses, 0U);
    EXPECT_EQ(watch->counts().starts, 1U);
    // 300 where nothing else runs, or in virtual time.
    EXPECT_GE(watch->counts().frames, 150U);
    EXPECT_LE(watch->counts().frames + watch->counts().dropped, 301U);
  }
  say_frames("four vivid cameras", frames);
}

TEST(VividDevices, AreListedAsCameras) {
  LinuxCalls calls;
  int cameras = 0;
  for (const V4l2Device& device : list_v4l2_devices(calls)) {
    if (device.driver != "vivid") continue;
    EXPECT_FALSE(device.unusable);
    EXPECT_EQ(device.bus, vivid_bus(cameras));
    ++cameras;
  }
  EXPECT_EQ(cameras, 4);
}

// The line that the virtual machine's summary shows.
class Total final : public testing::Environment {
 public:
  void TearDown() override {
    if (frames_said() > 0) say_frames("vivid", frames_said());
  }
};
[[maybe_unused]] testing::Environment* const kTotal = testing::AddGlobalTestEnvironment(new Total);

}  // namespace
}  // namespace cupola
