// The fake camera: its pictures, its times, its script, and a day of four of them.
// SPDX-License-Identifier: MIT
#include "hal/camera/fake_camera.h"

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "hal/camera/camera_planes.h"
#include "hal/camera/camera_watch.h"
#include "tests/hal/camera_viewer.h"
#include "tests/hal/sanitized.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr std::array<CameraFormat, kCameraFormats> kFormats = {
    CameraFormat::kYuyv, CameraFormat::kUyvy,  CameraFormat::kNv12,  CameraFormat::kI420,
    CameraFormat::kI422, CameraFormat::kRgb24, CameraFormat::kBgr24, CameraFormat::kXrgb32,
    CameraFormat::kGrey, CameraFormat::kMjpeg, CameraFormat::kP010};

TEST(CameraNames, AreThoseOfV4l2AndBackAgain) {
  for (const CameraFormat format : kFormats) {
    CameraFormat back = CameraFormat::kYuyv;
    EXPECT_TRUE(format_of(name_of(format), back)) << name_of(format);
    EXPECT_EQ(back, format);
  }
  CameraFormat untouched = CameraFormat::kGrey;
  EXPECT_FALSE(format_of("yuyv", untouched));
  EXPECT_FALSE(format_of("", untouched));
  EXPECT_EQ(untouched, CameraFormat::kGrey);
}

TEST(CameraNames, SayWhatIsWrong) {
  EXPECT_EQ(describe({CameraCause::kBusy, "VIDIOC_STREAMON", EBUSY}),
            "VIDIOC_STREAMON: busy: somebody else has it: Device or resource busy");
  EXPECT_EQ(describe({CameraCause::kSilent, "", 0}), "silent");
  for (std::size_t i = 0; i < kCameraCauses; ++i) EXPECT_STRNE(name_of(static_cast<CameraCause>(i)), "");
}

TEST(FakePicture, TellsCameraAndSequenceInEveryFormat) {
  for (const CameraFormat format : kFormats) {
    for (const int width : {40, 41, 64, 333}) {
      const FakePicture picture(format, width, 17, 201);
      std::vector<std::uint8_t> memory(picture.bytes());
      picture.prepare(memory);
      for (const std::uint32_t sequence : {0U, 1U, 255U, 0xfffffffeU, 0x12345678U}) {
        CameraFrame frame;
        picture.describe(memory.data(), picture.draw(memory, sequence), frame);
        EXPECT_TRUE(is_whole(frame));
        EXPECT_EQ(frame.width, width);
        EXPECT_EQ(read_stamp(frame), (PictureStamp{201, sequence})) << name_of(format) << " " << width;
      }
    }
  }
}

TEST(FakePicture, Moves) {
  for (const CameraFormat format : kFormats) {
    const FakePicture picture(format, 64, 48, 0);
    std::vector<std::uint8_t> memory(picture.bytes());
    picture.prepare(memory);
    picture.draw(memory, 7);
    const std::vector<std::uint8_t> before = memory;
    picture.draw(memory, 8);
    int moved = 0;
    for (std::size_t i = memory.size() / 8; i < memory.size() / 2; ++i) moved += memory[i] != before[i];
    EXPECT_GT(moved, 0) << name_of(format);
  }
}

TEST(FakePicture, RefusesToBeTooNarrow) {
  EXPECT_THROW(FakePicture(CameraFormat::kGrey, 39, 48, 0), std::runtime_error);
  EXPECT_THROW(FakePicture(CameraFormat::kGrey, 64, 0, 0), std::runtime_error);
  EXPECT_THROW(FakePicture(CameraFormat::kGrey, 65536, 48, 0), std::runtime_error);
}

// Polls for `duration`; the times at which frames were captured.
std::vector<nanoseconds> watch(FakeClock& clock, FakeCamera& camera, nanoseconds duration) {
  std::vector<nanoseconds> times;
  const nanoseconds end = clock.now() + duration;
  while (clock.now() < end) {
    CameraFrame frame;
    CameraTrouble trouble;
    while (camera.poll(frame, trouble) == CameraPoll::kFrame) {
      times.push_back(frame.captured_at);
      camera.give_back(frame);
    }
    const std::array<int, 1> descriptors = {camera.descriptor()};
    clock.wait(descriptors, end);
  }
  return times;
}

TEST(FakeCamera, KeepsItsRate) {
  FakeClock clock;
  FakeCamera camera(clock, {});
  CameraSetup setup;
  for (const double rate : {0.0, 24.0, 60.0, 1000.0}) {
    setup.rate = rate;
    ASSERT_TRUE(std::holds_alternative<CameraMode>(camera.start(setup)));
    const auto times = watch(clock, camera, 10s);
    EXPECT_NEAR(static_cast<double>(times.size()), 10.0 * (rate > 0.0 ? rate : 60.0), 1.0);
  }
}

TEST(FakeCamera, DriftsAndTrembles) {
  FakeClock clock;
  FakeCameraDevice slow;
  slow.drift_ppm = 1000.0;
  slow.jitter = 2ms;
  FakeCamera camera(clock, slow);
  camera.start({});
  const auto times = watch(clock, camera, 1000s);
  EXPECT_NEAR(static_cast<double>(times.size()), 60000.0 / 1.001, 2.0);
  nanoseconds shortest = 1s;
  nanoseconds longest = 0s;
  for (std::size_t i = 1; i < times.size(); ++i) {
    shortest = std::min(shortest, times[i] - times[i - 1]);
    longest = std::max(longest, times[i] - times[i - 1]);
  }
  EXPECT_NEAR(static_cast<double>((longest - shortest).count()), 4e6, 1e5);
}

TEST(FakeCamera, TakesAnotherFrameTimeFromTheNextFrameOn) {
  FakeClock clock;
  FakeCamera camera(clock, {});
  EXPECT_FALSE(camera.set_control({"frame_time", 20000.0})) << "not while it is stopped";
  camera.start({});
  std::vector<nanoseconds> stamps;
  const auto run = [&](int frames) {
    while (frames > 0) {
      CameraFrame frame;
      CameraTrouble trouble;
      if (camera.poll(frame, trouble) == CameraPoll::kFrame) {
        stamps.push_back(frame.captured_at);
        camera.give_back(frame);
        --frames;
        continue;
      }
      const std::array<int, 1> descriptors = {camera.descriptor()};
      clock.wait(descriptors, clock.now() + 1s);
    }
  };
  run(3);
  EXPECT_TRUE(camera.set_control({"frame_time", 20000.0}));
  EXPECT_FALSE(camera.set_control({"frame_time", 0.0}));
  EXPECT_FALSE(camera.set_control({"focus", 1.0}));
  run(3);
  EXPECT_NEAR(static_cast<double>((stamps[2] - stamps[1]).count()), 16'666'667.0, 2.0);
  EXPECT_EQ(stamps[3] - stamps[2], 20ms);
  EXPECT_EQ(stamps[5] - stamps[4], 20ms);
}

TEST(FakeCamera, FollowsItsScript) {
  FakeClock clock;
  FakeCameraDevice device;
  device.faults = {{CameraFault::kSilent, 1s, 2s, 0}, {CameraFault::kDropped, 3s, 4s, 50}};
  FakeCamera camera(clock, device);
  camera.start({});
  EXPECT_NEAR(static_cast<double>(watch(clock, camera, 1s).size()), 60.0, 1.0);
  EXPECT_NEAR(static_cast<double>(watch(clock, camera, 1s).size()), 0.0, 1.0);
  EXPECT_NEAR(static_cast<double>(watch(clock, camera, 1s).size()), 60.0, 1.0);
  EXPECT_NEAR(static_cast<double>(watch(clock, camera, 1s).size()), 30.0, 1.0);
  EXPECT_NEAR(static_cast<double>(watch(clock, camera, 1s).size()), 60.0, 1.0);
}

TEST(FakeCamera, SaysAtOnceThatItWasUnplugged) {
  FakeClock clock;
  FakeCameraDevice device;
  device.rate = 1.0;
  device.faults = {{CameraFault::kUnplugged, 2500ms, 10s, 0}};
  FakeCamera camera(clock, device);
  camera.start({});
  EXPECT_EQ(watch(clock, camera, 2100ms).size(), 2U);
  const std::array<int, 1> descriptors = {camera.descriptor()};
  EXPECT_TRUE(clock.wait(descriptors, 1h));
  EXPECT_EQ(clock.now(), 2500ms);
  CameraFrame frame;
  CameraTrouble trouble;
  EXPECT_EQ(camera.poll(frame, trouble), CameraPoll::kLost);
  EXPECT_EQ(trouble.cause, CameraCause::kMissing);
}

TEST(FakeCamera, RefusesWhatItHasNot) {
  FakeClock clock;
  FakeCamera camera(clock, {});
  const auto cause = [&](const CameraSetup& setup) {
    const auto started = camera.start(setup);
    const CameraTrouble* trouble = std::get_if<CameraTrouble>(&started);
    return trouble ? trouble->cause : CameraCause::kSilent;
  };
  CameraSetup setup;
  setup.formats = {CameraFormat::kGrey};
  EXPECT_EQ(cause(setup), CameraCause::kUnsupported);
  setup = {};
  setup.controls = {{"focus", 2.0}};
  EXPECT_EQ(cause(setup), CameraCause::kUnsupported);
  setup = {};
  setup.buffers = 1;
  EXPECT_EQ(cause(setup), CameraCause::kUnsupported);
  FakeCameraDevice narrow;
  narrow.width = 16;
  FakeCamera too_narrow(clock, narrow);
  EXPECT_TRUE(std::holds_alternative<CameraTrouble>(too_narrow.start({})));
  FakeCameraDevice still;
  still.rate = 0.0;
  EXPECT_THROW(FakeCamera(clock, still), std::runtime_error);
}

TEST(FourFakeCameras, RunForADayInSeconds) {
  constexpr nanoseconds kDay = test::kSanitized ? 2h : 24h;
  FakeClock clock;
  std::vector<std::unique_ptr<FakeCamera>> cameras;
  std::vector<std::unique_ptr<CameraWatch>> watches;
  for (int i = 0; i < 4; ++i) {
    FakeCameraDevice device;
    device.number = i;
    device.width = 40;
    device.height = 2;
    device.first_sequence = 0xffff0000U;  // wraps after 18 minutes
    device.faults = {{CameraFault::kUnplugged, (i + 1) * kDay / 5, (i + 1) * kDay / 5 + 1s, 0}};
    cameras.push_back(std::make_unique<FakeCamera>(clock, device));
    watches.push_back(std::make_unique<CameraWatch>(*cameras.back(), CameraSetup{}, clock, 100ms));
  }
  std::array<int, 4> descriptors{};
  std::array<std::uint64_t, 4> last{};
  bool in_order = true;
  while (clock.now() < kDay) {
    nanoseconds deadline = kDay;
    for (std::size_t i = 0; i < 4; ++i) {
      CameraFrame frame;
      CameraWatch::Poll polled{};
      while ((polled = watches[i]->poll(frame)) != CameraWatch::Poll::kNothing) {
        if (polled != CameraWatch::Poll::kFrame) continue;
        in_order = in_order && frame.sequence > last[i];
        last[i] = frame.sequence;
        watches[i]->give_back(frame);
      }
      descriptors[i] = watches[i]->descriptor();
      deadline = std::min(deadline, watches[i]->deadline());
    }
    clock.wait(descriptors, deadline);
  }
  EXPECT_TRUE(in_order);
  std::uint64_t frames = 0;
  for (const auto& watched : watches) {
    EXPECT_NEAR(static_cast<double>(watched->counts().frames), 60.0 * static_cast<double>((kDay - 1s) / 1s),
                3.0);
    EXPECT_EQ(watched->counts().dropped, 0U);
    EXPECT_EQ(watched->counts().losses, 1U);
    EXPECT_EQ(watched->counts().clock_steps, 0U);
    frames += watched->counts().frames;
  }
  say_frames("FourFakeCameras", frames);
}

}  // namespace
}  // namespace cupola
