// A camera of JPEG pictures, decoded in poll() on a fake clock and on a thread of its own on the real one.
// SPDX-License-Identifier: MIT
#include "hal/camera/mjpeg_camera.h"

#include <gtest/gtest.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <deque>
#include <mutex>

#include "hal/camera/camera_watch.h"
#include "hal/camera/fake_camera.h"
#include "tests/hal/test_jpeg.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using Decoding = MjpegCamera::Decoding;

int brightness(int number) {
  return 30 + 10 * (number % 20);
}

// The luma of picture `number` is even, of brightness(number).
std::vector<std::uint8_t> picture(int number, int down = 2) {
  test::JpegMaking making;
  making.down = down;
  return test::make_jpeg(making, [&](int c, int, int) { return c == 0 ? brightness(number) : 90 + 20 * c; });
}

// Sends what it is told to, from any thread.
class ScriptedCamera final : public Camera {
 public:
  ScriptedCamera() : event_(eventfd(0, EFD_SEMAPHORE | EFD_NONBLOCK | EFD_CLOEXEC)) {}
  ~ScriptedCamera() override { close(event_); }

  std::variant<CameraMode, CameraTrouble> start(const CameraSetup& setup) noexcept override {
    const std::scoped_lock lock(mutex_);
    ++starts;
    CameraMode mode;
    mode.format = sends_mjpeg ? CameraFormat::kMjpeg : CameraFormat::kYuyv;
    mode.width = 64;
    mode.height = 48;
    mode.rate = 60.0;
    mode.crop = {0, 0, 64, 48};
    setup_ = setup;
    return mode;
  }
  void stop() noexcept override {
    const std::scoped_lock lock(mutex_);
    lent_ = 0;
  }
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept override {
    const std::scoped_lock lock(mutex_);
    if (queue_.empty()) return CameraPoll::kNothing;
    const CameraPoll kind = queue_.front().kind;
    if (kind == CameraPoll::kLost) {
      trouble = {CameraCause::kMissing, "script", 0};
      return kind;  // for good
    }
    frame = {};
    frame.sequence = sequence_++;
    if (kind == CameraPoll::kFrame) {
      shown_.push_back(std::move(queue_.front().jpeg));
      frame.format = CameraFormat::kMjpeg;
      frame.width = 64;
      frame.height = 48;
      frame.planes[0] = {shown_.back().data(), 0, shown_.back().size(), -1, 0};
      frame.buffer = static_cast<int>(shown_.size()) - 1;
      ++lent_;
    }
    queue_.pop_front();
    std::uint64_t one = 0;
    [[maybe_unused]] const auto taken = read(event_, &one, sizeof one);
    return kind;
  }
  void give_back(const CameraFrame&) noexcept override {
    const std::scoped_lock lock(mutex_);
    --lent_;
  }
  int descriptor() const noexcept override { return event_; }

  void send(CameraPoll kind, std::vector<std::uint8_t> jpeg = {}) {
    const std::scoped_lock lock(mutex_);
    queue_.push_back({kind, std::move(jpeg)});
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto given = write(event_, &one, sizeof one);
  }
  int lent() {
    const std::scoped_lock lock(mutex_);
    return lent_;
  }

  bool sends_mjpeg = true;
  int starts = 0;

 private:
  struct Sent {
    CameraPoll kind;
    std::vector<std::uint8_t> jpeg;
  };
  std::mutex mutex_;
  int event_;
  CameraSetup setup_;
  std::deque<Sent> queue_;
  std::deque<std::vector<std::uint8_t>> shown_;
  std::uint64_t sequence_ = 0;
  int lent_ = 0;
};

class Mjpeg : public testing::TestWithParam<Decoding> {
 protected:
  Mjpeg() {
    auto scripted = std::make_unique<ScriptedCamera>();
    device_ = scripted.get();
    camera_ = std::make_unique<MjpegCamera>(std::move(scripted), clock_, GetParam());
  }
  CameraMode start(int down = 2) {
    device_->send(CameraPoll::kFrame, picture(0, down));  // from which it learns the kind
    const auto answer = camera_->start(setup_);
    const CameraMode* mode = std::get_if<CameraMode>(&answer);
    EXPECT_TRUE(mode);
    return mode ? *mode : CameraMode{};
  }
  // Within five seconds.
  CameraPoll next() {
    const auto end = clock_.now() + 5s;
    for (;;) {
      const CameraPoll poll = camera_->poll(frame_, trouble_);
      if (poll != CameraPoll::kNothing || clock_.now() > end) return poll;
      const int descriptors[] = {camera_->descriptor()};
      clock_.wait(descriptors, clock_.now() + 20ms);
    }
  }
  void expect_picture(int number) {
    ASSERT_EQ(next(), CameraPoll::kFrame);
    EXPECT_NEAR(frame_.planes[0].data[20 * frame_.planes[0].stride + 30], brightness(number), 1);
    EXPECT_NEAR(frame_.planes[1].data[5], 110, 1);
    EXPECT_NEAR(frame_.planes[2].data[5], 130, 1);
  }

  MonotonicClock clock_;
  ScriptedCamera* device_ = nullptr;
  std::unique_ptr<MjpegCamera> camera_;
  CameraSetup setup_;
  CameraFrame frame_;
  CameraTrouble trouble_;
};

TEST_P(Mjpeg, DecodesPicturesAsTheyAreCompressed) {
  for (const int down : {2, 1}) {
    const CameraMode mode = start(down);
    EXPECT_EQ(mode.format, down == 2 ? CameraFormat::kI420 : CameraFormat::kI422);
    EXPECT_TRUE(mode.full_range);
    EXPECT_FALSE(mode.bt709);
    for (int i = 0; i < 20; ++i) {
      device_->send(CameraPoll::kFrame, picture(i, down));
      expect_picture(i);
      EXPECT_EQ(frame_.format, mode.format);
      EXPECT_EQ(device_->lent(), 0) << "the device has its buffer back";
      camera_->give_back(frame_);
    }
    // The kind of what comes next is another one.
    device_->send(CameraPoll::kFrame, picture(0, 3 - down));
    EXPECT_EQ(next(), CameraPoll::kLost);
    EXPECT_EQ(trouble_.cause, CameraCause::kChanged);
    EXPECT_EQ(next(), CameraPoll::kLost) << "until it is started again";
  }
}

TEST_P(Mjpeg, LendsPicturesUntilTheyAreGivenBack) {
  setup_.buffers = 4;
  start();
  std::vector<CameraFrame> lent;
  for (int i = 0; i < 4; ++i) {
    device_->send(CameraPoll::kFrame, picture(i));
    expect_picture(i);
    lent.push_back(frame_);
  }
  for (int i = 0; i < 4; ++i) {
    const CameraFrame& frame = lent[static_cast<std::size_t>(i)];
    EXPECT_NEAR(frame.planes[0].data[100], brightness(i), 1) << "untouched by those after it";
    camera_->give_back(frame);
    camera_->give_back(frame);
  }
  device_->send(CameraPoll::kFrame, picture(9));
  expect_picture(9);
}

TEST_P(Mjpeg, TellsDamageAndLossInTheirOrder) {
  start();
  device_->send(CameraPoll::kFrame, picture(1));
  expect_picture(1);
  camera_->give_back(frame_);
  const std::uint64_t before = frame_.sequence;
  std::vector<std::uint8_t> cut = picture(2);
  cut.resize(cut.size() / 2);
  device_->send(CameraPoll::kFrame, cut);
  EXPECT_EQ(next(), CameraPoll::kDamaged);
  EXPECT_EQ(frame_.sequence, before + 1);
  device_->send(CameraPoll::kDamaged);
  EXPECT_EQ(next(), CameraPoll::kDamaged) << "by the device";
  EXPECT_EQ(frame_.sequence, before + 2);
  device_->send(CameraPoll::kFrame, picture(3));
  device_->send(CameraPoll::kLost);
  expect_picture(3);
  EXPECT_EQ(next(), CameraPoll::kLost);
  EXPECT_EQ(trouble_.cause, CameraCause::kMissing);
  camera_->stop();
  EXPECT_EQ(camera_->poll(frame_, trouble_), CameraPoll::kLost) << "the device's own answer";
}

TEST_P(Mjpeg, RefusesPicturesThatTheWarpDoesNotRead) {
  test::JpegMaking making;
  making.down = 1;
  making.across = 1;
  device_->send(CameraPoll::kFrame, test::make_jpeg(making, [](int, int, int) { return 100; }));
  auto answer = camera_->start(setup_);
  const CameraTrouble* trouble = std::get_if<CameraTrouble>(&answer);
  ASSERT_TRUE(trouble);
  EXPECT_EQ(trouble->cause, CameraCause::kUnsupported) << describe(*trouble);
  making = {};
  making.width = 32;
  device_->send(CameraPoll::kFrame, test::make_jpeg(making, [](int, int, int) { return 100; }));
  answer = camera_->start(setup_);
  trouble = std::get_if<CameraTrouble>(&answer);
  ASSERT_TRUE(trouble);
  EXPECT_EQ(trouble->cause, CameraCause::kChanged) << describe(*trouble);
  EXPECT_EQ(device_->lent(), 0);
}

TEST_P(Mjpeg, DecodesNoRowsBelowTheCrop) {
  setup_.crop = {8, 0, 20, 17};
  const CameraMode mode = start();
  EXPECT_EQ(mode.width, 64);
  EXPECT_EQ(mode.height, 18);
  EXPECT_EQ(mode.crop, (CameraArea{0, 0, 64, 18}));
  device_->send(CameraPoll::kFrame, picture(4));
  ASSERT_EQ(next(), CameraPoll::kFrame);
  EXPECT_EQ(frame_.height, 18);
  EXPECT_NEAR(frame_.planes[0].data[17 * frame_.planes[0].stride], brightness(4), 1);
}

TEST_P(Mjpeg, PassesOnWhatIsNoJpeg) {
  device_->sends_mjpeg = false;
  const auto answer = camera_->start(setup_);
  EXPECT_EQ(std::get<CameraMode>(answer).format, CameraFormat::kYuyv);
  device_->send(CameraPoll::kDamaged);
  EXPECT_EQ(next(), CameraPoll::kDamaged);
  EXPECT_EQ(camera_->descriptor(), device_->descriptor());
}

TEST_P(Mjpeg, StartsAndStopsAtAnyTime) {
  for (int i = 0; i < 50; ++i) {
    start();
    for (int n = 0; n < i % 5; ++n) device_->send(CameraPoll::kFrame, picture(n));
    if (i % 5 > 2) next();
    camera_->stop();
    EXPECT_EQ(device_->lent(), 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Decoding, Mjpeg, testing::Values(Decoding::kInPoll, Decoding::kOnAThread),
                         [](const auto& decoding) {
                           return std::string(decoding.param == Decoding::kInPoll ? "InPoll" : "OnAThread");
                         });

TEST(MjpegThread, ShowsTheNewestPictureWhenItCannotKeepUp) {
  MonotonicClock clock;
  auto scripted = std::make_unique<ScriptedCamera>();
  ScriptedCamera& device = *scripted;
  MjpegCamera camera(std::move(scripted), clock, Decoding::kOnAThread);
  for (int i = 0; i < 40; ++i) device.send(CameraPoll::kFrame, picture(i));
  ASSERT_TRUE(std::holds_alternative<CameraMode>(camera.start({})));
  CameraFrame frame;
  CameraTrouble trouble;
  while (camera.poll(frame, trouble) == CameraPoll::kNothing) clock.sleep_until(clock.now() + 1ms);
  EXPECT_EQ(frame.sequence, 39U) << "the first taught it the kind, 38 were passed over";
  EXPECT_EQ(device.lent(), 0);
}

TEST(MjpegThread, TellsWhenNoPictureComesToLearnFrom) {
  FakeClock clock;
  FakeCameraDevice device;
  device.formats = {CameraFormat::kMjpeg};
  device.faults = {{CameraFault::kSilent}};
  MjpegCamera camera(std::make_unique<FakeCamera>(clock, device), clock, Decoding::kInPoll);
  const auto answer = camera.start({});
  EXPECT_EQ(std::get<CameraTrouble>(answer).cause, CameraCause::kSilent);
  EXPECT_EQ(clock.now(), 2s);
}

}  // namespace
}  // namespace cupola
