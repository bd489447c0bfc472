// What every camera promises.
// SPDX-License-Identifier: MIT
#include "tests/hal/camera_contract.h"

namespace cupola {

TEST_P(CameraContract, StreamsFramesOfItsModeInOrder) {
  const CameraSetup setup = stage_->setup();
  const CameraMode mode = start(setup);
  EXPECT_EQ(mode.width, setup.width);
  EXPECT_EQ(mode.height, setup.height);
  EXPECT_NEAR(mode.rate, setup.rate, 0.1);
  EXPECT_NE(std::ranges::count(setup.formats, mode.format), 0);
  std::optional<CameraFrame> last;
  for (int i = 0; i < 120; ++i) {
    const std::optional<CameraFrame> frame = next();
    ASSERT_TRUE(frame);
    EXPECT_TRUE(fits(*frame, mode));
    EXPECT_TRUE(is_whole(*frame));
    EXPECT_LE(frame->captured_at, clock_.now() + period(mode));
    if (GetParam().stamped) {
      const std::optional<PictureStamp> stamp = read_stamp(*frame);
      ASSERT_TRUE(stamp);
      EXPECT_EQ(stamp->sequence, static_cast<std::uint32_t>(frame->sequence));
    }
    if (last) {
      EXPECT_GE(static_cast<std::uint32_t>(frame->sequence - last->sequence), 1U);
      EXPECT_LE(static_cast<std::uint32_t>(frame->sequence - last->sequence), 1U + frames_late(mode));
      const double step = static_cast<double>((frame->captured_at - last->captured_at).count());
      EXPECT_GT(step, 0.0);
      if (mode.rate > 0.0) {
        EXPECT_NEAR(step, 1e9 / mode.rate, 1e6 + static_cast<double>(GetParam().lateness.count()));
      }
    }
    last = frame;
    camera_.give_back(*frame);
  }
}

TEST_P(CameraContract, SaysNothingWhileStopped) {
  for (int round = 0; round < 2; ++round) {
    CameraFrame frame;
    CameraTrouble trouble;
    EXPECT_EQ(camera_.poll(frame, trouble), CameraPoll::kNothing);
    EXPECT_EQ(camera_.descriptor(), -1);
    camera_.give_back(frame);
    camera_.stop();
    start(stage_->setup());
    EXPECT_GE(camera_.descriptor(), 0);
    EXPECT_TRUE(next());
    camera_.stop();
  }
}

TEST_P(CameraContract, StartsAndStopsAgainAndAgain) {
  for (int round = 0; round < 3; ++round) {
    start(stage_->setup());
    for (int i = 0; i < 5; ++i) {
      const std::optional<CameraFrame> frame = next();
      ASSERT_TRUE(frame);
      camera_.give_back(*frame);
    }
    camera_.stop();
    camera_.stop();
  }
}

TEST_P(CameraContract, StartsAnewWhileItRuns) {
  for (int round = 0; round < 4; ++round) {
    const CameraMode mode = start(stage_->setup());
    const std::chrono::nanoseconds begun = clock_.now();
    const std::optional<CameraFrame> frame = next();
    ASSERT_TRUE(frame);
    EXPECT_TRUE(fits(*frame, mode));
    EXPECT_LE(clock_.now() - begun, 2 * period(mode) + GetParam().lateness);
    // Sometimes with a frame lent, sometimes without.
    if (round % 2 == 0) camera_.give_back(*frame);
  }
}

TEST_P(CameraContract, LendsEveryNumberOfBuffers) {
  for (const int buffers : {2, 3, 5, 8, 13, 32}) {
    CameraSetup setup = stage_->setup();
    setup.buffers = buffers;
    const CameraMode mode = start(setup);
    for (int i = 0; i < 2 * buffers; ++i) {
      const std::optional<CameraFrame> frame = next();
      ASSERT_TRUE(frame) << buffers;
      camera_.give_back(*frame);
    }
    // All lent: the device drops frames, and goes on when it has a buffer again.
    std::vector<CameraFrame> lent;
    for (bool more = true; more && lent.size() < 40;) {
      more = false;
      clock_.sleep_until(clock_.now() + 2 * period(mode) + GetParam().lateness);
      for (CameraFrame frame; poll(frame); more = true) lent.push_back(frame);
    }
    frames_ += lent.size();
    ASSERT_FALSE(lent.empty());
    const int all = GetParam().buffers > 0 ? GetParam().buffers : buffers;
    EXPECT_GE(static_cast<int>(lent.size()), all - 1);
    EXPECT_LE(static_cast<int>(lent.size()), std::max(all, 4)) << "some drivers insist on a few";
    clock_.sleep_until(clock_.now() + 3 * period(mode));
    for (const CameraFrame& frame : lent) camera_.give_back(frame);
    const std::optional<CameraFrame> frame = next();
    ASSERT_TRUE(frame) << buffers;
    EXPECT_GE(static_cast<std::uint32_t>(frame->sequence - lent.back().sequence),
              GetParam().counts_drops ? 3U : 1U);
  }
}

TEST_P(CameraContract, LeavesLentFramesAlone) {
  start(stage_->setup());
  const std::optional<CameraFrame> kept = next();
  ASSERT_TRUE(kept);
  const std::uint64_t sum = sum_of(*kept);
  for (int i = 0; i < 30; ++i) {
    const std::optional<CameraFrame> frame = next();
    ASSERT_TRUE(frame);
    EXPECT_NE(frame->buffer, kept->buffer);
    EXPECT_NE(frame->planes[0].data, kept->planes[0].data);
    camera_.give_back(*frame);
  }
  EXPECT_EQ(sum_of(*kept), sum);
}

TEST_P(CameraContract, PassesOverWhatIsNotLent) {
  start(stage_->setup());
  const std::optional<CameraFrame> frame = next();
  ASSERT_TRUE(frame);
  camera_.give_back(*frame);
  camera_.give_back(*frame);
  for (const int buffer : {-1, 4, 31, 32, 1'000'000, -1'000'000}) {
    CameraFrame nobodys = *frame;
    nobodys.buffer = buffer;
    camera_.give_back(nobodys);
  }
  for (int i = 0; i < 12; ++i) {
    const std::optional<CameraFrame> later = next();
    ASSERT_TRUE(later);
    camera_.give_back(*later);
  }
  camera_.stop();
  camera_.give_back(*frame);
}

TEST_P(CameraContract, WakesThoseWhoWaitForItsDescriptor) {
  start(stage_->setup());
  int woken = 0;
  for (int i = 0; i < 60; ++i) {
    const std::array<int, 1> descriptors = {camera_.descriptor()};
    ASSERT_TRUE(clock_.wait(descriptors, clock_.now() + std::chrono::seconds(1)));
    CameraFrame frame;
    if (!poll(frame)) continue;
    ++woken;
    ++frames_;
    camera_.give_back(frame);
  }
  EXPECT_GE(woken, 55) << "hardly ever for nothing";
}

TEST_P(CameraContract, RefusesADeviceThatIsNotThere) {
  CameraSetup setup = stage_->setup();
  setup.device = "no camera has this name";
  const auto started = camera_.start(setup);
  const CameraTrouble* trouble = std::get_if<CameraTrouble>(&started);
  ASSERT_TRUE(trouble);
  EXPECT_EQ(trouble->cause, CameraCause::kMissing);
  EXPECT_EQ(camera_.descriptor(), -1);
  start(stage_->setup());
  EXPECT_TRUE(next());
}

TEST_P(CameraContract, RefusesASizeThatItHasNot) {
  CameraSetup setup = stage_->setup();
  setup.width = 23456;
  setup.height = 16788;
  const auto started = camera_.start(setup);
  const CameraTrouble* trouble = std::get_if<CameraTrouble>(&started);
  ASSERT_TRUE(trouble);
  EXPECT_EQ(trouble->cause, CameraCause::kUnsupported);
  EXPECT_EQ(camera_.descriptor(), -1);
}

TEST_P(CameraContract, TakesTheSizeThatTheDeviceIsSetTo) {
  CameraSetup setup = stage_->setup();
  start(setup);
  setup.width = setup.height = 0;
  setup.rate = 0.0;
  const CameraMode mode = start(setup);
  EXPECT_GT(mode.width, 0);
  EXPECT_GT(mode.height, 0);
  const std::optional<CameraFrame> frame = next();
  ASSERT_TRUE(frame);
  EXPECT_TRUE(fits(*frame, mode));
}

}  // namespace cupola
