// The watch on its own: a camera that says what the test tells it to.
// SPDX-License-Identifier: MIT
#include "hal/camera/camera_watch.h"

#include <cerrno>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using Poll = CameraWatch::Poll;

constexpr nanoseconds kPeriod = 10ms;

class ScriptedCamera final : public Camera {
 public:
  std::variant<CameraMode, CameraTrouble> start(const CameraSetup& setup) noexcept override {
    ++starts;
    asked = setup;
    lent = 0;
    if (refusal) return *refusal;
    return mode;
  }
  void stop() noexcept override { ++stops; }
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept override {
    if (loss) {
      trouble = *loss;
      loss.reset();
      return CameraPoll::kLost;
    }
    if (frames.empty()) return endless_damage ? CameraPoll::kDamaged : CameraPoll::kNothing;
    frame = frames.front();
    frames.pop_front();
    ++lent;
    return CameraPoll::kFrame;
  }
  void give_back(const CameraFrame&) noexcept override { --lent; }
  int descriptor() const noexcept override { return 17; }
  bool set_control(const CameraControl& control) noexcept override {
    controls.emplace_back(control.name, control.value);
    return control.name != "gain";
  }

  void send(std::uint64_t sequence, nanoseconds captured_at) {
    CameraFrame frame;
    frame.format = CameraFormat::kGrey;
    frame.width = 4;
    frame.height = 2;
    frame.planes[0] = {texels.data(), 4, texels.size(), -1, 0};
    frame.sequence = sequence;
    frame.captured_at = captured_at;
    frames.push_back(frame);
  }

  std::vector<std::uint8_t> texels = std::vector<std::uint8_t>(8);
  CameraMode mode{CameraFormat::kGrey, 4, 2, 100.0, {0, 0, 4, 2}, false, false};
  std::optional<CameraTrouble> refusal;
  std::optional<CameraTrouble> loss;
  std::deque<CameraFrame> frames;
  bool endless_damage = false;
  CameraSetup asked;
  std::vector<std::pair<std::string, double>> controls;
  int starts = 0;
  int stops = 0;
  int lent = 0;
};

class Watch : public testing::Test {
 protected:
  static CameraSetup setup() {
    CameraSetup setup;
    setup.width = 4;
    setup.height = 2;
    return setup;
  }
  // Sends one frame, captured now, and polls it; the first one is told by kBack before.
  void flow(std::uint64_t sequence) {
    camera_.send(sequence, clock_.now());
    Poll polled = watch_.poll(frame_);
    if (polled == Poll::kBack) polled = watch_.poll(frame_);
    ASSERT_EQ(polled, Poll::kFrame);
  }
  // Ten frames from `sequence` on, a period apart.
  void begin(std::uint64_t sequence = 0) {
    for (std::uint64_t i = 0; i < 10; ++i) {
      flow(sequence + i);
      watch_.give_back(frame_);
      clock_.advance(kPeriod);
    }
  }

  FakeClock clock_;
  ScriptedCamera camera_;
  CameraWatch watch_{camera_, setup(), clock_, 50ms};
  CameraFrame frame_;
};

TEST_F(Watch, SaysThatTheCameraCameBeforeItsFirstFrame) {
  EXPECT_EQ(watch_.descriptor(), -1);
  EXPECT_LE(watch_.deadline(), clock_.now());
  EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
  EXPECT_EQ(watch_.descriptor(), 17);
  EXPECT_EQ(watch_.state(), CameraState::kLost);
  camera_.send(5, 0ns);
  EXPECT_EQ(watch_.poll(frame_), Poll::kBack);
  EXPECT_EQ(watch_.state(), CameraState::kStreaming);
  EXPECT_LE(watch_.deadline(), clock_.now()) << "the frame is there already";
  EXPECT_EQ(watch_.poll(frame_), Poll::kFrame);
  EXPECT_EQ(frame_.sequence, 5U);
  EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
  EXPECT_EQ(watch_.deadline(), clock_.now() + 50ms);
  EXPECT_EQ(watch_.counts().frames, 1U);
}

TEST_F(Watch, TurnsDialsOnceAndAgainInEveryStreamThatBegins) {
  using Dial = CameraWatch::Dial;
  watch_.turn(Dial::kExposure, 4000.0);
  EXPECT_TRUE(camera_.controls.empty()) << "there is no stream yet";
  begin();
  const std::pair<std::string, double> exposure{"exposure", 4000.0};
  EXPECT_EQ(camera_.controls, std::vector{exposure});
  watch_.turn(Dial::kGain, 2.0);
  watch_.turn(Dial::kFrameTime, 10010.0);
  camera_.controls.clear();
  watch_.poll(frame_);
  watch_.poll(frame_);
  const std::vector<std::pair<std::string, double>> all = {exposure, {"gain", 2.0}, {"frame_time", 10010.0}};
  EXPECT_EQ(camera_.controls, all) << "refused ones are not tried again and again";
  camera_.controls.clear();
  camera_.loss = CameraTrouble{CameraCause::kMissing, "poll", 0};
  EXPECT_EQ(watch_.poll(frame_), Poll::kLost);
  EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
  EXPECT_EQ(camera_.controls, all) << "the camera forgot them";
}

TEST_F(Watch, TellsAFailedFirstStartOnceAndTriesEveryPeriod) {
  camera_.refusal = CameraTrouble{CameraCause::kBusy, "open", EBUSY};
  EXPECT_EQ(watch_.poll(frame_), Poll::kLost);
  EXPECT_EQ(watch_.trouble().cause, CameraCause::kBusy);
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
    clock_.advance(10ms);
  }
  EXPECT_EQ(camera_.starts, 10) << "every 40 ms, as the rate is not known";
  EXPECT_EQ(watch_.counts().failed_starts, 10U);
  EXPECT_EQ(watch_.counts().of(CameraCause::kBusy), 1U);
  EXPECT_EQ(watch_.counts().losses, 0U) << "no frame ever flowed";
  camera_.refusal.reset();
  clock_.advance(40ms);
  flow(0);
}

TEST_F(Watch, CountsEachCauseOfOneLoss) {
  begin();
  camera_.loss = CameraTrouble{CameraCause::kChanged, "event", 0};
  EXPECT_EQ(watch_.poll(frame_), Poll::kLost);
  for (const CameraCause cause : {CameraCause::kNoSignal, CameraCause::kNoSignal, CameraCause::kMissing}) {
    camera_.refusal = CameraTrouble{cause, "", 0};
    EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
    EXPECT_EQ(watch_.trouble().cause, cause);
    clock_.advance(kPeriod);
  }
  EXPECT_EQ(watch_.counts().losses, 1U);
  EXPECT_EQ(watch_.counts().of(CameraCause::kChanged), 1U);
  EXPECT_EQ(watch_.counts().of(CameraCause::kNoSignal), 1U);
  EXPECT_EQ(watch_.counts().of(CameraCause::kMissing), 1U);
}

TEST_F(Watch, BarksAtACameraThatNeverBeginsButGivesItTime) {
  EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
  clock_.sleep_until(watch_.deadline());
  EXPECT_EQ(clock_.now(), 50ms);
  EXPECT_EQ(watch_.poll(frame_), Poll::kLost);
  EXPECT_EQ(watch_.counts().silences, 1U);
  EXPECT_EQ(camera_.starts, 1);
  clock_.sleep_until(1500ms);
  EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
  EXPECT_EQ(camera_.starts, 1);
  camera_.send(0, clock_.now());
  EXPECT_EQ(watch_.poll(frame_), Poll::kBack);
  EXPECT_EQ(watch_.poll(frame_), Poll::kFrame);
  EXPECT_EQ(watch_.counts().losses, 1U);
}

TEST_F(Watch, StartsASilentCameraAgainEveryTwoSeconds) {
  begin();
  clock_.sleep_until(watch_.deadline());
  EXPECT_EQ(watch_.poll(frame_), Poll::kLost);
  const nanoseconds lost_at = clock_.now();
  EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
  EXPECT_EQ(camera_.starts, 2) << "at once";
  while (clock_.now() < lost_at + 9s) {
    clock_.sleep_until(std::max(watch_.deadline(), clock_.now()));
    EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
  }
  EXPECT_EQ(camera_.starts, 6);
  EXPECT_EQ(watch_.counts().silences, 1U);
  EXPECT_EQ(watch_.counts().losses, 1U);
}

TEST_F(Watch, UnwrapsTheSequenceAndCountsItsGaps) {
  begin(0xfffffffaU);
  EXPECT_EQ(frame_.sequence, 0x100000003U);
  EXPECT_EQ(watch_.counts().dropped, 0U);
  flow(7);
  EXPECT_EQ(frame_.sequence, 0x100000007U);
  EXPECT_EQ(watch_.counts().dropped, 3U);
}

TEST_F(Watch, TakesACounterThatStandsStillOrGoesBackForARestart) {
  begin(100);
  clock_.advance(kPeriod);
  flow(109);
  EXPECT_EQ(frame_.sequence, 110U);
  clock_.advance(kPeriod);
  flow(0);
  EXPECT_EQ(frame_.sequence, 111U);
  clock_.advance(kPeriod);
  flow(2);
  EXPECT_EQ(frame_.sequence, 113U);
  EXPECT_EQ(watch_.counts().dropped, 1U);
}

TEST_F(Watch, GoesOnCountingInTheNextRun) {
  begin(100);
  camera_.loss = CameraTrouble{};
  EXPECT_EQ(watch_.poll(frame_), Poll::kLost);
  clock_.advance(kPeriod);
  flow(0);
  EXPECT_EQ(frame_.sequence, 110U);
  EXPECT_EQ(watch_.counts().dropped, 0U);
}

TEST_F(Watch, DoesNotCompareTheCountersOfTwoRuns) {
  begin();
  camera_.loss = CameraTrouble{};
  EXPECT_EQ(watch_.poll(frame_), Poll::kLost);
  clock_.advance(kPeriod);
  flow(1000);
  EXPECT_EQ(frame_.sequence, 10U);
  EXPECT_EQ(watch_.counts().dropped, 0U);
}

TEST_F(Watch, PassesOverFramesOfAnEarlierRun) {
  begin();
  flow(10);
  const CameraFrame old = frame_;
  camera_.loss = CameraTrouble{};
  EXPECT_EQ(watch_.poll(frame_), Poll::kLost);
  EXPECT_EQ(camera_.stops, 0) << "lent frames can be read until the next poll";
  watch_.give_back(old);
  EXPECT_EQ(camera_.lent, 1);
  clock_.advance(kPeriod);
  flow(0);
  EXPECT_EQ(camera_.lent, 1);
  watch_.give_back(old);
  EXPECT_EQ(camera_.lent, 1);
  watch_.give_back(frame_);
  EXPECT_EQ(camera_.lent, 0);
}

TEST_F(Watch, KeepsTheTimesOfFramesThatWaited) {
  begin();
  const nanoseconds before = clock_.now();
  clock_.advance(3 * kPeriod);
  for (std::uint64_t i = 0; i < 3; ++i) camera_.send(10 + i, before + i * kPeriod);
  for (std::uint64_t i = 0; i < 3; ++i) {
    ASSERT_EQ(watch_.poll(frame_), Poll::kFrame);
    EXPECT_EQ(frame_.captured_at, before + i * kPeriod);
  }
  EXPECT_EQ(watch_.counts().clock_steps, 0U);
}

TEST_F(Watch, ReplacesTimesAfterAClockStepAlsoOfFramesThatWaited) {
  begin();
  const nanoseconds before = clock_.now();
  clock_.advance(2 * kPeriod);
  for (std::uint64_t i = 0; i < 3; ++i) camera_.send(10 + i, before + i * kPeriod - 70ms);
  for (std::uint64_t i = 0; i < 3; ++i) {
    ASSERT_EQ(watch_.poll(frame_), Poll::kFrame);
    EXPECT_EQ(frame_.captured_at, before + i * kPeriod);
  }
  EXPECT_EQ(watch_.counts().clock_steps, 1U);
}

TEST_F(Watch, CountsOneWrongTimeOnce) {
  for (const nanoseconds wrong :
       {nanoseconds(99h), nanoseconds(-99h), nanoseconds::min(), nanoseconds::max()}) {
    begin();
    const std::uint64_t steps = watch_.counts().clock_steps;
    clock_.advance(kPeriod);
    camera_.send(10, wrong);
    ASSERT_EQ(watch_.poll(frame_), Poll::kFrame);
    EXPECT_LE(frame_.captured_at, clock_.now());
    EXPECT_GE(frame_.captured_at, clock_.now() - 2 * kPeriod);
    for (std::uint64_t i = 0; i < 5; ++i) {
      clock_.advance(kPeriod);
      flow(11 + i);
      EXPECT_EQ(frame_.captured_at, clock_.now());
    }
    EXPECT_EQ(watch_.counts().clock_steps, steps + 1);
    watch_.stop();
  }
}

TEST_F(Watch, FollowsADeviceClockOfItsOwnAcrossItsWrap) {
  // Modulo 2^64 nanoseconds, as drivers count that were told to wrap.
  const auto device_time = [&] {
    return nanoseconds(
        static_cast<std::int64_t>(static_cast<std::uint64_t>(clock_.now().count()) + 0x7fffffffffff0000U));
  };
  for (std::uint64_t i = 0; i < 100; ++i) {
    camera_.send(i, device_time());
    Poll polled = watch_.poll(frame_);
    if (polled == Poll::kBack) polled = watch_.poll(frame_);
    ASSERT_EQ(polled, Poll::kFrame);
    EXPECT_EQ(frame_.captured_at, clock_.now());
    clock_.advance(kPeriod);
  }
  EXPECT_EQ(watch_.counts().clock_steps, 1U);
}

TEST_F(Watch, CountsOneStepThoughItsFirstFrameCameLate) {
  for (const nanoseconds latency : {35ms, 26ms, 17ms, 1ms, 0ms, 2ms, 1ms, 0ms}) {
    camera_.send(watch_.counts().frames, clock_.now() + 1h);
    clock_.advance(latency);
    Poll polled = watch_.poll(frame_);
    if (polled == Poll::kBack) polled = watch_.poll(frame_);
    ASSERT_EQ(polled, Poll::kFrame);
    EXPECT_LE(frame_.captured_at, clock_.now());
    EXPECT_GE(frame_.captured_at, clock_.now() - 2 * kPeriod);
    clock_.advance(40ms - latency);
  }
  EXPECT_EQ(watch_.counts().clock_steps, 1U);
}

TEST_F(Watch, KeepsFramesApartThatAreStampedAhead) {
  begin();
  camera_.send(10, clock_.now() + 4ms);
  camera_.send(11, clock_.now() + 6ms);
  ASSERT_EQ(watch_.poll(frame_), Poll::kFrame);
  EXPECT_EQ(frame_.captured_at, clock_.now());
  const nanoseconds first = frame_.captured_at;
  ASSERT_EQ(watch_.poll(frame_), Poll::kFrame);
  EXPECT_GT(frame_.captured_at, first);
  EXPECT_EQ(watch_.counts().clock_steps, 0U);
}

TEST_F(Watch, LosesACameraWhoseFramesAreNotOfItsMode) {
  begin();
  camera_.send(10, clock_.now());
  camera_.frames.back().width = 3;
  EXPECT_EQ(watch_.poll(frame_), Poll::kLost);
  EXPECT_EQ(watch_.trouble().cause, CameraCause::kChanged);
}

TEST_F(Watch, CountsShortFramesAsDamagedAndGivesThemBack) {
  begin();
  camera_.send(10, clock_.now());
  camera_.frames.back().planes[0].bytes = 7;
  EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
  EXPECT_EQ(watch_.counts().damaged, 1U);
  EXPECT_EQ(camera_.lent, 0);
  clock_.advance(kPeriod);
  flow(11);
  EXPECT_EQ(watch_.counts().dropped, 0U);
}

TEST_F(Watch, IsNotHeldUpByEndlessDamage) {
  begin();
  camera_.endless_damage = true;
  EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
  clock_.advance(50ms);
  EXPECT_EQ(watch_.poll(frame_), Poll::kLost);
  EXPECT_EQ(watch_.counts().silences, 1U);
}

TEST_F(Watch, RefusesACameraThatCameBackAsAnother) {
  begin();
  camera_.loss = CameraTrouble{CameraCause::kMissing, "", ENODEV};
  EXPECT_EQ(watch_.poll(frame_), Poll::kLost);
  const CameraMode mode = camera_.mode;
  camera_.mode.crop.x = 1;
  EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
  EXPECT_EQ(watch_.trouble().cause, CameraCause::kChanged);
  EXPECT_EQ(camera_.stops, 1);
  clock_.advance(kPeriod);
  camera_.refusal = CameraTrouble{CameraCause::kUnsupported, "VIDIOC_S_FMT", EINVAL};
  EXPECT_EQ(watch_.poll(frame_), Poll::kNothing);
  EXPECT_EQ(watch_.trouble().cause, CameraCause::kChanged) << "it could do this before";
  EXPECT_EQ(watch_.counts().of(CameraCause::kChanged), 1U);
  camera_.refusal.reset();
  camera_.mode = mode;
  clock_.advance(kPeriod);
  flow(0);
}

TEST_F(Watch, TakesAnotherModeWhereTheSetupNamesNoSize) {
  watch_.set_setup({});
  begin();
  camera_.loss = CameraTrouble{};
  EXPECT_EQ(watch_.poll(frame_), Poll::kLost);
  camera_.mode.rate = 50.0;
  camera_.mode.height = 1;
  camera_.send(0, clock_.now());
  camera_.frames.back().height = 1;
  EXPECT_EQ(watch_.poll(frame_), Poll::kBack);
  EXPECT_EQ(watch_.mode().height, 1);
  EXPECT_EQ(watch_.poll(frame_), Poll::kFrame);
}

TEST_F(Watch, StopsAndBeginsWithAnotherSetup) {
  begin();
  CameraSetup other = setup();
  other.rate = 25.0;
  watch_.set_setup(other);
  EXPECT_EQ(camera_.stops, 1);
  EXPECT_EQ(watch_.descriptor(), -1);
  camera_.mode.height = 1;
  camera_.send(0, clock_.now());
  camera_.frames.back().height = 1;
  EXPECT_EQ(watch_.poll(frame_), Poll::kBack) << "another setup, so another mode is right";
  EXPECT_EQ(camera_.asked.rate, 25.0);
  EXPECT_EQ(watch_.counts().losses, 0U);
}

}  // namespace
}  // namespace cupola
