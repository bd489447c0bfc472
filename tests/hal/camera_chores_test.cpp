// Cameras whose start takes as long as the test wants: nobody waits for it who must not.
// SPDX-License-Identifier: MIT
#include "hal/camera/camera_chores.h"

#include <atomic>
#include <memory>
#include <semaphore>
#include <vector>

#include <gtest/gtest.h>
#include <poll.h>

#include "hal/camera/camera_watch.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using Poll = CameraWatch::Poll;

// Starts when it is let; fails the test where two use it at once.
class SlowCamera final : public Camera {
 public:
  std::variant<CameraMode, CameraTrouble> start(const CameraSetup&) noexcept override {
    const Use use(*this);
    ++starts;
    begun.release();
    let.acquire();
    if (refuses.load()) return CameraTrouble{CameraCause::kBusy, "open", 0};
    return mode;
  }
  void stop() noexcept override {
    const Use use(*this);
    ++stops;
  }
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept override {
    const Use use(*this);
    if (dies) {
      dies = false;
      trouble = {CameraCause::kMissing, "poll", 0};
      return CameraPoll::kLost;
    }
    frame = {};
    frame.format = mode.format;
    frame.width = mode.width;
    frame.height = mode.height;
    frame.planes[0] = {texels.data(), 4, texels.size(), -1, 0};
    frame.sequence = sequence++;
    return CameraPoll::kFrame;
  }
  void give_back(const CameraFrame&) noexcept override { const Use use(*this); }
  int descriptor() const noexcept override { return -1; }
  bool set_control(const CameraControl& control) noexcept override {  // while others poll
    begun.release();
    let.acquire();
    exposure = control.value;
    return true;
  }

  const CameraMode mode{CameraFormat::kGrey, 4, 2, 100.0, {0, 0, 4, 2}, false, false};
  std::counting_semaphore<> begun{0};
  std::counting_semaphore<> let{0};
  std::atomic<bool> refuses{false};
  std::atomic<int> starts{0};
  std::atomic<int> stops{0};
  std::atomic<int> clashes{0};
  std::atomic<double> exposure{0.0};
  bool dies = false;

 private:
  struct Use {
    explicit Use(SlowCamera& used) : camera(used) { camera.clashes += camera.used.exchange(true) ? 1 : 0; }
    ~Use() { camera.used = false; }
    SlowCamera& camera;
  };
  std::atomic<bool> used{false};
  std::vector<std::uint8_t> texels = std::vector<std::uint8_t>(8);
  std::uint64_t sequence = 0;
};

class SlowStart : public testing::Test {
 protected:
  ~SlowStart() override { EXPECT_EQ(camera_.clashes, 0) << "two threads at the camera"; }

  Poll poll() { return watch_->poll(frame_); }
  // As whoever polls waits for it.
  bool becomes_readable() {
    pollfd readable{watch_->descriptor(), POLLIN, 0};
    return watch_->descriptor() >= 0 && ::poll(&readable, 1, 60'000) == 1;
  }
  void start() {
    EXPECT_EQ(poll(), Poll::kNothing);
    camera_.begun.acquire();
    camera_.let.release();
    ASSERT_TRUE(becomes_readable());
  }

  FakeClock clock_;
  SlowCamera camera_;
  std::unique_ptr<CameraWatch> watch_ =
      std::make_unique<CameraWatch>(camera_, CameraSetup{}, clock_, 50ms, CameraWatch::Starting::kOnAThread);
  CameraFrame frame_;
};

TEST_F(SlowStart, HoldsUpNobody) {
  EXPECT_EQ(poll(), Poll::kNothing);
  camera_.begun.acquire();
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(poll(), Poll::kNothing);
    EXPECT_FALSE(watch_->running());
    EXPECT_GE(watch_->descriptor(), 0);
    EXPECT_EQ(watch_->deadline(), std::chrono::nanoseconds::max());
    clock_.advance(10ms);
  }
  EXPECT_EQ(camera_.starts, 1);
  camera_.let.release();
  ASSERT_TRUE(becomes_readable());
  EXPECT_EQ(poll(), Poll::kBack);
  EXPECT_EQ(poll(), Poll::kFrame);
  EXPECT_TRUE(watch_->running());
  EXPECT_EQ(watch_->counts().starts, 1U);
  EXPECT_EQ(watch_->counts().silences, 0U) << "the start's time is not the stream's";
}

TEST_F(SlowStart, ThatFailsIsToldOnceAndTriedAgainAfterAPeriod) {
  camera_.refuses = true;
  start();
  EXPECT_EQ(poll(), Poll::kLost);
  EXPECT_EQ(watch_->trouble().cause, CameraCause::kBusy);
  EXPECT_EQ(watch_->descriptor(), -1);
  EXPECT_EQ(watch_->deadline(), clock_.now() + 40ms);
  EXPECT_EQ(poll(), Poll::kNothing);
  EXPECT_EQ(camera_.starts, 1) << "not yet";
  clock_.advance(40ms);
  start();
  EXPECT_EQ(poll(), Poll::kNothing);
  camera_.refuses = false;
  clock_.advance(40ms);
  start();
  EXPECT_EQ(poll(), Poll::kBack);
  EXPECT_EQ(watch_->counts().failed_starts, 2U);
  EXPECT_EQ(watch_->counts().of(CameraCause::kBusy), 1U);
}

TEST_F(SlowStart, OfALostCameraTouchesNoFrameOfTheOldStream) {
  start();
  ASSERT_EQ(poll(), Poll::kBack);
  ASSERT_EQ(poll(), Poll::kFrame);
  const CameraFrame old = frame_;
  camera_.dies = true;
  EXPECT_EQ(poll(), Poll::kLost);
  EXPECT_EQ(poll(), Poll::kNothing);
  camera_.begun.acquire();
  watch_->give_back(old);  // while the thread has the camera: passed over
  camera_.let.release();
  ASSERT_TRUE(becomes_readable());
  EXPECT_EQ(poll(), Poll::kBack);
  EXPECT_EQ(watch_->counts().losses, 1U);
  EXPECT_EQ(watch_->counts().starts, 2U);
}

TEST_F(SlowStart, SetsControlsWhileFramesFlow) {
  start();
  ASSERT_EQ(poll(), Poll::kBack);
  watch_->turn(CameraWatch::Dial::kExposure, 1000.0);
  EXPECT_EQ(poll(), Poll::kFrame);
  camera_.begun.acquire();
  watch_->turn(CameraWatch::Dial::kExposure, 2000.0);  // while the one before is under way
  for (int i = 0; i < 10; ++i) EXPECT_EQ(poll(), Poll::kFrame) << i;
  EXPECT_EQ(camera_.exposure, 0.0);
  camera_.let.release(2);
  while (!camera_.begun.try_acquire()) EXPECT_EQ(poll(), Poll::kFrame);
  watch_->stop();
  EXPECT_EQ(camera_.exposure, 2000.0) << "the last one counts";
}

TEST_F(SlowStart, IsWaitedForByAStop) {
  EXPECT_EQ(poll(), Poll::kNothing);
  camera_.let.release();
  watch_->stop();
  EXPECT_EQ(camera_.stops, 1);
  EXPECT_FALSE(watch_->running());
  start();
  EXPECT_EQ(poll(), Poll::kBack) << "it begins again";
}

TEST_F(SlowStart, IsWaitedForByTheEndOfTheWatch) {
  EXPECT_EQ(poll(), Poll::kNothing);
  camera_.let.release();
  watch_.reset();
  EXPECT_EQ(camera_.starts, 1);
  EXPECT_EQ(camera_.stops, 1);
}

}  // namespace
}  // namespace cupola
