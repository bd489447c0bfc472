// Cameras while they are recorded, beside the picture; and recordings as cameras.
// SPDX-License-Identifier: MIT
#include "hal/camera/recording_camera.h"

#include <gtest/gtest.h>

#include <cstring>
#include <deque>
#include <numeric>
#include <thread>

#include "hal/camera/camera_watch.h"
#include "hal/camera/fake_camera.h"
#include "hal/camera/recorded_camera.h"
#include "tests/frame/temporary_folder.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using Writing = CameraRecorder::Writing;

constexpr int kWidth = 64;
constexpr int kHeight = 48;

FakeCameraDevice device(std::vector<FakeFault> faults = {}) {
  FakeCameraDevice made;
  made.number = 9;
  made.formats = {CameraFormat::kNv12};
  made.faults = std::move(faults);
  return made;
}

// Every byte is as the fake camera drew it for that sequence.
void expect_untorn(const CameraFrame& frame) {
  const FakePicture picture(CameraFormat::kNv12, kWidth, kHeight, 9);
  std::vector<std::uint8_t> memory(picture.bytes());
  picture.prepare(memory);
  CameraFrame expected;
  picture.describe(memory.data(), picture.draw(memory, static_cast<std::uint32_t>(frame.sequence)), expected);
  for (std::size_t p = 0; p < 2; ++p) {
    ASSERT_EQ(frame.planes[p].bytes, expected.planes[p].bytes);
    ASSERT_EQ(std::memcmp(frame.planes[p].data, expected.planes[p].data, expected.planes[p].bytes), 0)
        << "frame " << frame.sequence;
  }
}

class Recorded : public testing::TestWithParam<Writing> {
 protected:
  RecordingCamera record(FakeCameraDevice device) {
    return RecordingCamera(std::make_unique<FakeCamera>(clock_, std::move(device)), clock_, 0ns,
                           std::make_unique<CameraRecorder>(file_, GetParam()));
  }
  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "front.camera";
  FakeClock clock_;
};

// The fake camera draws into a buffer as soon as it has it back, as a driver does.
TEST_P(Recorded, FramesAreNeverTorn) {
  constexpr int kFrames = 3000;
  std::uint64_t recorded = 0;
  {
    RecordingCamera camera = record(device());
    ASSERT_TRUE(std::holds_alternative<CameraMode>(camera.start({})));
    std::deque<CameraFrame> lent;
    for (int polled = 0; polled < kFrames;) {
      clock_.advance(16'666'667ns);
      CameraFrame frame;
      CameraTrouble trouble;
      while (camera.poll(frame, trouble) == CameraPoll::kFrame) {
        ++polled;
        lent.push_back(frame);
        // Sometimes at once, sometimes when three others came.
        while (lent.size() > static_cast<std::size_t>(polled / 7 % 4)) {
          camera.give_back(lent.front());
          lent.pop_front();
        }
      }
      if (polled % 500 == 0) camera.start({});
      if (polled % 10 == 0) std::this_thread::sleep_for(100us);
    }
    camera.stop();
    EXPECT_EQ(camera.counts().error, 0);
    recorded = camera.counts().frames;
    if (GetParam() == Writing::kAtOnce) {
      EXPECT_EQ(camera.counts().passed_over, 0U);
    }
  }
  const RecordingReader reader(file_);
  std::uint64_t frames = 0;
  std::chrono::nanoseconds before{0};
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const CameraRecord record = reader.at(i);
    EXPECT_GE(record.seen_at, before);
    before = record.seen_at;
    if (record.kind != RecordKind::kFrame) continue;
    ++frames;
    ASSERT_NO_FATAL_FAILURE(expect_untorn(record.frame));
  }
  EXPECT_GE(frames, recorded);
  EXPECT_GT(frames, 0U);
}

TEST_P(Recorded, TroublesAreNeverPassedOver) {
  {
    RecordingCamera camera =
        record(device({{CameraFault::kUnplugged, 1s, 2s}, {CameraFault::kDamaged, 3s, 4s, 50}}));
    CameraWatch watch(camera, {}, clock_, 100ms);
    while (clock_.now() < 5s) {
      CameraFrame frame;
      if (watch.poll(frame) == CameraWatch::Poll::kFrame) watch.give_back(frame);
      // A second of them in no time would be more than the ring holds.
      if (watch.state() == CameraState::kLost) std::this_thread::sleep_for(4ms);
      const int descriptors[] = {watch.descriptor()};
      clock_.wait(descriptors, std::min<std::chrono::nanoseconds>(watch.deadline(), 5s));
    }
    EXPECT_EQ(watch.counts().losses, 1U);
    EXPECT_EQ(watch.counts().damaged, 30U);
  }
  const RecordingReader reader(file_);
  std::array<int, 5> kinds{};
  for (std::size_t i = 0; i < reader.size(); ++i) ++kinds[static_cast<std::size_t>(reader.at(i).kind)];
  EXPECT_EQ(kinds[static_cast<std::size_t>(RecordKind::kStarted)], 2);
  EXPECT_GT(kinds[static_cast<std::size_t>(RecordKind::kRefused)], 50);
  EXPECT_EQ(kinds[static_cast<std::size_t>(RecordKind::kDamaged)], 30);
  EXPECT_EQ(kinds[static_cast<std::size_t>(RecordKind::kLost)], 1);
}

// On a thread, frames would be passed over as fast as the fake clock runs.
TEST(RecordedCamera, SaysAgainWhatItSaidAtTheSameTimes) {
  const TemporaryFolder folder;
  FakeClock clock;
  struct Seen {
    std::chrono::nanoseconds at;
    CameraWatch::Poll kind;
    std::uint64_t sequence;
    std::chrono::nanoseconds captured_at;
    std::uint64_t sum;  // of its bytes
    bool operator==(const Seen&) const = default;
  };
  const auto watch_it = [](Camera& camera, FakeClock& now) {
    std::vector<Seen> seen;
    CameraWatch watch(camera, {}, now, 100ms);
    while (now.now() < 4s) {
      CameraFrame frame;
      const auto kind = watch.poll(frame);
      if (kind == CameraWatch::Poll::kFrame) {
        std::uint64_t sum = 0;
        for (const CameraPlane& plane : frame.planes)
          sum = std::accumulate(plane.data, plane.data + plane.bytes, 31 * sum);
        seen.push_back({now.now(), kind, frame.sequence, frame.captured_at, sum});
        watch.give_back(frame);
        continue;
      }
      if (kind != CameraWatch::Poll::kNothing) seen.push_back({now.now(), kind, 0, 0ns, 0});
      const int descriptors[] = {watch.descriptor()};
      now.wait(descriptors, std::min<std::chrono::nanoseconds>(watch.deadline(), 4s));
    }
    return seen;
  };
  std::vector<Seen> live;
  {
    FakeCameraDevice unsteady = device({{CameraFault::kDropped, 0s, 10s, 10},
                                        {CameraFault::kUnplugged, 1s, 1100ms},
                                        {CameraFault::kSilent, 2s, 3s}});
    unsteady.jitter = 900us;
    unsteady.latency = 2ms;
    RecordingCamera camera(std::make_unique<FakeCamera>(clock, unsteady), clock, 0ns,
                           std::make_unique<CameraRecorder>(folder / "camera", Writing::kAtOnce));
    live = watch_it(camera, clock);
  }
  FakeClock later;
  ReplayTime time;
  RecordedCamera camera(later, time, folder / "camera");
  EXPECT_EQ(watch_it(camera, later), live);
  EXPECT_GT(live.size(), 100U);
}

// As a live show starts its cameras: whole, and again with a crop.
TEST(RecordedCamera, BeginsWithTheStartThatFramesCameOfWhereItIsToldTo) {
  const TemporaryFolder folder;
  {
    FakeClock clock;
    FakeCameraDevice cutting = device();
    cutting.crop = FakeCrop::kCuts;
    RecordingCamera camera(std::make_unique<FakeCamera>(clock, cutting), clock, 0ns,
                           std::make_unique<CameraRecorder>(folder / "camera", Writing::kAtOnce));
    camera.start({});
    CameraSetup setup;
    setup.crop = {8, 8, 48, 32};
    camera.start(setup);
    clock.advance(20ms);
    CameraFrame frame;
    CameraTrouble trouble;
    ASSERT_EQ(camera.poll(frame, trouble), CameraPoll::kFrame);
  }
  FakeClock clock;
  ReplayTime time;
  RecordedCamera from_begin(clock, time, folder / "camera");
  EXPECT_EQ(std::get<CameraMode>(from_begin.start({})).width, kWidth);
  RecordedCamera camera(clock, time, folder / "camera");
  camera.pass_over_empty_starts();
  EXPECT_EQ(std::get<CameraMode>(camera.start({})).width, 48);
  clock.advance(20ms);
  CameraFrame frame;
  CameraTrouble trouble;
  ASSERT_EQ(camera.poll(frame, trouble), CameraPoll::kFrame);
  EXPECT_EQ(frame.width, 48);
}

TEST(RecordedCamera, EndsInSilenceAndDoesNotStartAgain) {
  const TemporaryFolder folder;
  {
    FakeClock clock;
    RecordingCamera camera(std::make_unique<FakeCamera>(clock, device()), clock, 0ns,
                           std::make_unique<CameraRecorder>(folder / "camera", Writing::kAtOnce));
    camera.start({});
    clock.advance(20ms);
    CameraFrame frame;
    CameraTrouble trouble;
    ASSERT_EQ(camera.poll(frame, trouble), CameraPoll::kFrame);
  }
  MonotonicClock clock;  // a real one will do
  ReplayTime time;
  RecordedCamera camera(clock, time, folder / "camera");
  EXPECT_EQ(camera.descriptor(), -1) << "not started";
  CameraFrame frame;
  CameraTrouble trouble;
  EXPECT_EQ(camera.poll(frame, trouble), CameraPoll::kNothing);
  ASSERT_TRUE(std::holds_alternative<CameraMode>(camera.start({})));
  const int descriptors[] = {camera.descriptor()};
  EXPECT_TRUE(clock.wait(descriptors, clock.now() + 10s));
  EXPECT_GE(clock.now(), *time.begin + 20ms);
  ASSERT_EQ(camera.poll(frame, trouble), CameraPoll::kFrame);
  EXPECT_EQ(camera.poll(frame, trouble), CameraPoll::kNothing);
  EXPECT_FALSE(clock.wait(descriptors, clock.now())) << "for good";
  const auto again = camera.start({});
  const auto* refused = std::get_if<CameraTrouble>(&again);
  ASSERT_TRUE(refused);
  EXPECT_EQ(describe(*refused), "the recording's end: no such device");
}

INSTANTIATE_TEST_SUITE_P(Ways, Recorded, testing::Values(Writing::kAtOnce, Writing::kOnAThread),
                         [](const auto& way) {
                           return std::string(way.param == Writing::kAtOnce ? "AtOnce" : "OnAThread");
                         });

}  // namespace
}  // namespace cupola
