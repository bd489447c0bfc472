// Runs inside a virtual machine (tests/vm/guest): libcamera's "Sensor B" of the kernel's vimc driver.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/camera/libcamera_camera.h"
#include "hal/time/clock.h"
#include "tests/hal/camera_contract.h"
#include "tests/hal/camera_viewer.h"
#include "tests/hal/heap_allocations.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr const char* kModel = "Sensor B";

CameraSetup vimc_setup() {
  CameraSetup setup;
  setup.device = kModel;
  setup.formats = {CameraFormat::kNv12, CameraFormat::kRgb24};  // it has no NV12
  setup.width = 318;  // multiples of 6: libcamera 0.0.3 takes no others
  setup.height = 240;
  return setup;
}

class VimcStage final : public CameraStage {
 public:
  Clock& clock() override { return clock_; }
  Camera& camera() override { return camera_; }
  CameraSetup setup() override { return vimc_setup(); }
  void begin_fault(CameraFault, std::int64_t) override {}
  void end_faults() override {}

  LibcameraSystem& system() { return system_; }

 private:
  MonotonicClock clock_;
  LibcameraSystem system_;
  LibcameraCamera camera_{system_, clock_};
};

std::unique_ptr<CameraStage> make_stage() {
  return std::make_unique<VimcStage>();
}
const CameraStageMaker kMaker{.name = "vimc",
                              .make = make_stage,
                              .lateness = 200ms,
                              .stamped = false,
                              .faults = {},
                              .counts_drops = false,
                              .buffers = 4};
INSTANTIATE_TEST_SUITE_P(Vimc, CameraContract, testing::Values(kMaker),
                         [](const auto& maker) { return std::string(maker.param.name); });

class Vimc : public testing::Test {
 protected:
  ~Vimc() override {
    if (frames_ > 0) say_frames("vimc", frames_);
  }

  std::optional<CameraMode> start(Camera& camera, const CameraSetup& setup) {
    const auto answer = camera.start(setup);
    if (const auto* trouble = std::get_if<CameraTrouble>(&answer)) {
      trouble_ = *trouble;
      return std::nullopt;
    }
    return std::get<CameraMode>(answer);
  }
  CameraCause refusal(const CameraSetup& setup) {
    EXPECT_FALSE(start(camera_, setup));
    EXPECT_EQ(camera_.descriptor(), -1);
    return trouble_.cause;
  }
  // kNothing: for two seconds.
  CameraPoll wait(Camera& camera, CameraFrame& frame) {
    const nanoseconds end = clock_.now() + 2s;
    for (;;) {
      const CameraPoll polled = camera.poll(frame, trouble_);
      frames_ += polled == CameraPoll::kFrame;
      if (polled != CameraPoll::kNothing) return polled;
      const std::array<int, 1> descriptors = {camera.descriptor()};
      if (!clock_.wait(descriptors, end)) return CameraPoll::kNothing;
    }
  }
  // Tries for five seconds until the camera starts, or until there is no such camera.
  bool starts() {
    return keep_trying([this] { return start(camera_, vimc_setup()).has_value(); });
  }
  bool goes_missing() {
    return keep_trying(
        [this] { return !start(camera_, vimc_setup()) && trouble_.cause == CameraCause::kMissing; });
  }
  template <typename Try>
  bool keep_trying(Try succeeds) {
    const nanoseconds end = clock_.now() + 5s;
    while (!succeeds()) {
      if (clock_.now() > end) return false;
      clock_.sleep_until(clock_.now() + 20ms);
    }
    return true;
  }

  VimcStage stage_;
  Clock& clock_ = stage_.clock();
  LibcameraSystem& system_ = stage_.system();
  Camera& camera_ = stage_.camera();
  CameraTrouble trouble_;
  std::uint64_t frames_ = 0;
};

TEST_F(Vimc, IsListedAsAnUsableCamera) {
  ASSERT_FALSE(system_.trouble());
  const std::vector<LibcameraListing> cameras = system_.list();
  ASSERT_EQ(cameras.size(), 1U);
  EXPECT_EQ(cameras[0].model, kModel);
  EXPECT_NE(cameras[0].id, "");
  EXPECT_EQ(cameras[0].trouble, "");
}

TEST_F(Vimc, IsFoundByItsIdItsModelAndItsPlace) {
  const std::string id = system_.list().at(0).id;
  for (const std::string& name : {id, std::string(kModel), std::string("#0")}) {
    CameraSetup setup = vimc_setup();
    setup.device = name;
    EXPECT_TRUE(start(camera_, setup)) << name << ": " << describe(trouble_);
  }
}

TEST_F(Vimc, IsMissingUnderEveryOtherName) {
  for (const char* name : {"", "Sensor A", "sensor b", "#1", "/dev/video0", "Sensor B "}) {
    CameraSetup setup = vimc_setup();
    setup.device = name;
    EXPECT_EQ(refusal(setup), CameraCause::kMissing) << name;
  }
}

TEST_F(Vimc, StreamsAHundredFramesWithoutAGap) {
  const auto mode = start(camera_, vimc_setup());
  ASSERT_TRUE(mode) << describe(trouble_);
  EXPECT_EQ(mode->format, CameraFormat::kRgb24);
  std::optional<CameraFrame> last;
  while (frames_ < 100) {
    CameraFrame frame;
    ASSERT_EQ(wait(camera_, frame), CameraPoll::kFrame) << frames_;
    ASSERT_TRUE(fits(frame, *mode));
    ASSERT_TRUE(is_whole(frame));
    ASSERT_GE(frame.planes[0].dma_buf, 0);
    ASSERT_LE(frame.captured_at, clock_.now());
    ASSERT_GT(frame.captured_at, clock_.now() - 1s) << "of another clock";
    if (last) {
      ASSERT_EQ(frame.sequence, last->sequence + 1);
      ASSERT_GT(frame.captured_at, last->captured_at);
    }
    last = frame;
    camera_.give_back(frame);
  }
}

TEST_F(Vimc, AllocatesNothingOnTheCallersThread) {
  ASSERT_TRUE(start(camera_, vimc_setup())) << describe(trouble_);
  const std::uint64_t before = heap_allocations();
  while (frames_ < 30) {
    CameraFrame frame;
    if (wait(camera_, frame) != CameraPoll::kFrame) break;
    camera_.give_back(frame);
  }
  EXPECT_EQ(heap_allocations() - before, 0U);
  EXPECT_EQ(frames_, 30U);
}

TEST_F(Vimc, StopsTwentyTimesWithRequestsOnTheirWay) {
  for (int round = 0; round < 20; ++round) {
    ASSERT_TRUE(start(camera_, vimc_setup())) << describe(trouble_);
    // Some rounds stop before a frame came, some with frames lent.
    for (int i = 0; i < round % 4; ++i) {
      CameraFrame frame;
      ASSERT_EQ(wait(camera_, frame), CameraPoll::kFrame);
      if (i % 2 == 0) camera_.give_back(frame);
    }
    camera_.stop();
  }
}

TEST_F(Vimc, BelongsToOneAtATime) {
  ASSERT_TRUE(start(camera_, vimc_setup()));
  LibcameraCamera second(system_, clock_);
  EXPECT_FALSE(start(second, vimc_setup()));
  EXPECT_EQ(trouble_.cause, CameraCause::kBusy);
  EXPECT_NE(system_.list().at(0).trouble, "");
  CameraFrame frame;
  EXPECT_EQ(wait(camera_, frame), CameraPoll::kFrame);
  camera_.stop();
  EXPECT_TRUE(start(second, vimc_setup())) << describe(trouble_);
}

TEST_F(Vimc, RefusesASizeThatItWouldChange) {
  CameraSetup setup = vimc_setup();
  setup.width = 319;
  EXPECT_EQ(refusal(setup), CameraCause::kUnsupported);
}

TEST_F(Vimc, RefusesFormatsThatItHasNot) {
  CameraSetup setup = vimc_setup();
  setup.formats = {CameraFormat::kNv12, CameraFormat::kMjpeg};
  EXPECT_EQ(refusal(setup), CameraCause::kUnsupported);
}

// The second of eight bars is yellow; the driver writes its settings across the upper rows.
TEST_F(Vimc, SendsBytesInTheOrderOfTheirName) {
  for (const CameraFormat format : {CameraFormat::kRgb24, CameraFormat::kBgr24}) {
    CameraSetup setup = vimc_setup();
    setup.formats = {format};
    const auto mode = start(camera_, setup);
    ASSERT_TRUE(mode) << describe(trouble_);
    ASSERT_EQ(mode->format, format);
    CameraFrame frame;
    ASSERT_EQ(wait(camera_, frame), CameraPoll::kFrame);
    const std::ptrdiff_t x = frame.width * 3 / 16;
    const std::uint8_t* texel =
        frame.planes[0].data + frame.planes[0].stride * (frame.height * 15 / 16) + 3 * x;
    const int red = texel[format == CameraFormat::kRgb24 ? 0 : 2];
    const int blue = texel[format == CameraFormat::kRgb24 ? 2 : 0];
    EXPECT_GT(red, blue + 100) << name_of(format);
  }
}

TEST_F(Vimc, TakesTheControlsThatItHas) {
  std::array<std::uint64_t, 2> light{};
  for (const int bright : {0, 1}) {
    CameraSetup setup = vimc_setup();
    setup.controls = {{"Brightness", bright ? 0.5 : -0.5}, {"trigger", 0.0}};
    ASSERT_TRUE(start(camera_, setup)) << describe(trouble_);
    CameraFrame frame;
    for (int i = 0; i < 8; ++i) {
      ASSERT_EQ(wait(camera_, frame), CameraPoll::kFrame);
      camera_.give_back(frame);
    }
    ASSERT_EQ(wait(camera_, frame), CameraPoll::kFrame);
    for (std::size_t i = 0; i < frame.planes[0].bytes; ++i) light[bright] += frame.planes[0].data[i];
  }
  EXPECT_GT(light[1], light[0]);
}

TEST_F(Vimc, RefusesControlsThatItHasNot) {
  for (const char* name :
       {"exposure", "gain", "white_balance", "auto_exposure", "ColourGains.red", "No such"}) {
    CameraSetup setup = vimc_setup();
    setup.controls = {{name, 1.0}};
    EXPECT_EQ(refusal(setup), CameraCause::kUnsupported) << name;
  }
  EXPECT_TRUE(start(camera_, vimc_setup())) << describe(trouble_);
}

void order_driver(const char* what) {
  std::ofstream(std::string("/sys/bus/platform/drivers/vimc/") + what) << "vimc.0" << std::flush;
}

TEST_F(Vimc, ComesBackEachTimeThatItIsPluggedIn) {
  for (int round = 0; round < 10; ++round) {
    order_driver("unbind");
    EXPECT_TRUE(goes_missing());
    order_driver("bind");
    ASSERT_TRUE(starts()) << describe(trouble_);
    CameraFrame frame;
    EXPECT_EQ(wait(camera_, frame), CameraPoll::kFrame);
    camera_.stop();
  }
}

TEST(VimcDriver, IsGoneWithItsModuleAndBackWithIt) {
  ASSERT_EQ(std::system("modprobe -r vimc && udevadm settle"), 0);
  EXPECT_TRUE(LibcameraSystem().list().empty());
  ASSERT_EQ(std::system("modprobe vimc && udevadm settle"), 0);
  EXPECT_EQ(LibcameraSystem().list().size(), 1U);
}

}  // namespace
}  // namespace cupola
