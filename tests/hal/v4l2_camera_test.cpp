// V4L2 cameras: which device is taken, what is agreed with it, and what its frames say.
// SPDX-License-Identifier: MIT
#include "hal/camera/v4l2_camera.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "hal/camera/camera_planes.h"
#include "hal/camera/v4l2_devices.h"
#include "tests/hal/camera_viewer.h"
#include "tests/hal/fake_v4l2.h"
#include "tests/hal/fake_v4l2_node.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

class V4l2 : public testing::Test {
 protected:
  ~V4l2() override {
    camera_.stop();
    EXPECT_EQ(calls_.complaints(), "");
  }
  CameraMode start(const CameraSetup& setup) {
    const auto started = camera_.start(setup);
    if (const CameraTrouble* trouble = std::get_if<CameraTrouble>(&started)) {
      ADD_FAILURE() << describe(*trouble);
      return {};
    }
    return std::get<CameraMode>(started);
  }
  CameraTrouble refusal(const CameraSetup& setup) {
    const auto started = camera_.start(setup);
    EXPECT_TRUE(std::holds_alternative<CameraTrouble>(started));
    EXPECT_EQ(camera_.descriptor(), -1);
    return std::holds_alternative<CameraTrouble>(started) ? std::get<CameraTrouble>(started)
                                                          : CameraTrouble{};
  }
  CameraPoll next(CameraFrame& frame, CameraTrouble& trouble) {
    const std::array<int, 1> descriptors = {camera_.descriptor()};
    CameraPoll polled = CameraPoll::kNothing;
    for (int i = 0; i < 10 && polled == CameraPoll::kNothing; ++i) {
      clock_.wait(descriptors, clock_.now() + 1s);
      polled = camera_.poll(frame, trouble);
    }
    return polled;
  }
  CameraFrame next() {
    CameraFrame frame;
    CameraTrouble trouble;
    EXPECT_EQ(next(frame, trouble), CameraPoll::kFrame) << describe(trouble);
    return frame;
  }
  static CameraSetup only(CameraFormat format) {
    CameraSetup setup;
    setup.formats = {format};
    return setup;
  }

  FakeClock clock_;
  FakeV4l2 calls_{clock_};
  V4l2Camera camera_{calls_, clock_};
};

FakeV4l2Device numbered(int number) {
  FakeV4l2Device device;
  device.number = number;
  device.node = 3 * number;
  device.card = number == 0 ? "Dome" : "Wide";
  device.bus = "usb-" + std::to_string(number);
  return device;
}

TEST_F(V4l2, FindsDevicesByPathBusAndCard) {
  FakeV4l2Device metadata = numbered(0);
  metadata.captures = false;
  metadata.node = 0;
  calls_.add(metadata);
  FakeV4l2Device dome = numbered(0);
  dome.node = 1;
  calls_.add(dome);
  calls_.add(numbered(1));
  calls_.add(numbered(2));
  const auto number_of = [&](const char* name) {
    CameraSetup setup;
    setup.device = name;
    start(setup);
    return read_stamp(next())->camera;
  };
  EXPECT_EQ(number_of(""), 0);
  EXPECT_EQ(number_of("Dome"), 0) << "not its metadata node";
  EXPECT_EQ(number_of("usb-0"), 0);
  EXPECT_EQ(number_of("Wide"), 1);
  EXPECT_EQ(number_of("usb-2"), 2);
  EXPECT_EQ(number_of("/dev/video6"), 2);
  CameraSetup setup;
  for (const char* nobody : {"usb-3", "wide", "Wid", "/dev/video7", "/dev/null"}) {
    setup.device = nobody;
    EXPECT_EQ(refusal(setup).cause, CameraCause::kMissing) << nobody;
  }
  setup.device = "/dev/video0";
  EXPECT_EQ(refusal(setup).cause, CameraCause::kUnsupported);
}

TEST_F(V4l2, ListsDevicesWithWhatKeepsThemFromUse) {
  calls_.add(numbered(0));
  FakeV4l2Device metadata = numbered(1);
  metadata.captures = false;
  calls_.add(metadata);
  calls_.add(numbered(2));
  calls_.fail(FakeV4l2::kOpen, 3, EACCES, false);
  const auto devices = list_v4l2_devices(calls_);
  ASSERT_EQ(devices.size(), 3U);
  EXPECT_EQ(devices[0].path, "/dev/video0");
  EXPECT_EQ(devices[0].card, "Dome");
  EXPECT_EQ(devices[0].bus, "usb-0");
  EXPECT_EQ(devices[0].driver, "fake");
  EXPECT_FALSE(devices[0].unusable);
  ASSERT_TRUE(devices[1].unusable);
  EXPECT_EQ(describe(*devices[1].unusable), "captures no video: not supported");
  ASSERT_TRUE(devices[2].unusable);
  EXPECT_EQ(describe(*devices[2].unusable), "open: the driver failed: Permission denied");
}

TEST_F(V4l2, FindsACameraThatCameBackAsAnotherNode) {
  FakeV4l2Node& node = calls_.add(numbered(1));
  CameraSetup setup;
  setup.device = "usb-1";
  CameraWatch watch(camera_, setup, clock_, 100ms);
  CameraFrame frame;
  watch.poll(frame);
  clock_.advance(20ms);
  EXPECT_EQ(watch.poll(frame), CameraWatch::Poll::kBack);
  node.begin_fault(CameraFault::kUnplugged, 0);
  EXPECT_EQ(watch.poll(frame), CameraWatch::Poll::kFrame);
  EXPECT_EQ(watch.poll(frame), CameraWatch::Poll::kLost);
  node.device().node = 17;
  node.end_faults();
  EXPECT_EQ(watch.poll(frame), CameraWatch::Poll::kNothing);
  clock_.advance(20ms);
  EXPECT_EQ(watch.poll(frame), CameraWatch::Poll::kBack);
}

TEST_F(V4l2, TriesAgainWhenOpenIsInterrupted) {
  calls_.add(numbered(0));
  calls_.fail(FakeV4l2::kOpen, 1, EINTR, false);
  start({});
}

TEST_F(V4l2, IsBusyWhenSomebodyElseStreams) {
  calls_.add(numbered(0));
  V4l2Camera other(calls_, clock_);
  ASSERT_TRUE(std::holds_alternative<CameraMode>(other.start({})));
  EXPECT_EQ(refusal({}).cause, CameraCause::kBusy);
  other.stop();
  start({});
  EXPECT_TRUE(read_stamp(next()));
}

struct Wire {
  __u32 fourcc;
  CameraFormat format;
  bool multi_planar;
};
constexpr std::array<Wire, 20> kWires = {{
    {V4L2_PIX_FMT_YUYV, CameraFormat::kYuyv, false},     {V4L2_PIX_FMT_UYVY, CameraFormat::kUyvy, false},
    {V4L2_PIX_FMT_NV12, CameraFormat::kNv12, false},     {V4L2_PIX_FMT_P010, CameraFormat::kP010, false},
    {V4L2_PIX_FMT_YUV420, CameraFormat::kI420, false},   {V4L2_PIX_FMT_YUV422P, CameraFormat::kI422, false},
    {V4L2_PIX_FMT_RGB24, CameraFormat::kRgb24, false},   {V4L2_PIX_FMT_BGR24, CameraFormat::kBgr24, false},
    {V4L2_PIX_FMT_XBGR32, CameraFormat::kXrgb32, false}, {V4L2_PIX_FMT_GREY, CameraFormat::kGrey, false},
    {V4L2_PIX_FMT_MJPEG, CameraFormat::kMjpeg, false},   {V4L2_PIX_FMT_YUYV, CameraFormat::kYuyv, true},
    {V4L2_PIX_FMT_NV12, CameraFormat::kNv12, true},      {V4L2_PIX_FMT_P010, CameraFormat::kP010, true},
    {V4L2_PIX_FMT_NV12M, CameraFormat::kNv12, true},     {V4L2_PIX_FMT_YUV420, CameraFormat::kI420, true},
    {V4L2_PIX_FMT_YUV420M, CameraFormat::kI420, true},   {V4L2_PIX_FMT_YUV422P, CameraFormat::kI422, true},
    {V4L2_PIX_FMT_YUV422M, CameraFormat::kI422, true},   {V4L2_PIX_FMT_MJPEG, CameraFormat::kMjpeg, true},
}};

// All rows of all planes.
void expect_picture(const CameraFrame& frame, int camera) {
  const FakePicture picture(frame.format, frame.width, frame.height, camera);
  std::vector<std::uint8_t> memory(picture.bytes());
  picture.prepare(memory);
  CameraFrame truth;
  picture.describe(memory.data(), picture.draw(memory, static_cast<std::uint32_t>(frame.sequence)), truth);
  for (int p = 0; p < plane_count(frame.format); ++p) {
    const CameraPlane& have = frame.planes[static_cast<std::size_t>(p)];
    const CameraPlane& want = truth.planes[static_cast<std::size_t>(p)];
    if (frame.format == CameraFormat::kMjpeg) {
      ASSERT_EQ(have.bytes, want.bytes);
      ASSERT_EQ(std::memcmp(have.data, want.data, want.bytes), 0);
      return;
    }
    const PlaneShape shape = plane_shape(frame.format, p, frame.width, frame.height);
    for (int y = 0; y < shape.rows; ++y) {
      ASSERT_EQ(std::memcmp(have.data + y * have.stride, want.data + y * want.stride,
                            static_cast<std::size_t>(shape.row_bytes)),
                0)
          << name_of(frame.format) << " plane " << p << " row " << y;
    }
  }
}

TEST_F(V4l2, ShowsEveryTexelOfEveryFormat) {
  for (const Wire& wire : kWires) {
    for (const __u32 padding : {0U, 2U, 64U}) {
      for (const int height : {48, 33}) {
        FakeV4l2Device device = numbered(0);
        device.fourccs = {wire.fourcc};
        device.multi_planar = wire.multi_planar;
        device.padding = padding;
        device.height = height;
        device.header = wire.multi_planar ? 40 : 0;
        FakeV4l2 calls(clock_);
        calls.add(device);
        V4l2Camera camera(calls, clock_);
        const auto started = camera.start(only(wire.format));
        ASSERT_TRUE(std::holds_alternative<CameraMode>(started))
            << describe(std::get<CameraTrouble>(started));
        for (int i = 0; i < 6; ++i) {
          clock_.advance(17ms);
          CameraFrame frame;
          CameraTrouble trouble;
          ASSERT_EQ(camera.poll(frame, trouble), CameraPoll::kFrame) << describe(trouble);
          EXPECT_TRUE(fits(frame, std::get<CameraMode>(started)));
          expect_picture(frame, 0);
          for (int p = 0; p < plane_count(frame.format); ++p) {
            EXPECT_GE(frame.planes[static_cast<std::size_t>(p)].dma_buf, 0);
          }
          EXPECT_EQ(frame.planes[0].offset, device.header);
          camera.give_back(frame);
        }
        camera.stop();
        EXPECT_EQ(calls.complaints(), "");
      }
    }
  }
}

TEST_F(V4l2, TakesTheFirstFormatOfTheSetupThatTheDeviceHas) {
  FakeV4l2Device device = numbered(0);
  device.fourccs = {V4L2_PIX_FMT_H264, V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_NV12, V4L2_PIX_FMT_YUYV};
  calls_.add(device);
  CameraSetup setup;
  EXPECT_EQ(start(setup).format, CameraFormat::kGrey) << "the device's first that is ours";
  setup.formats = {CameraFormat::kMjpeg, CameraFormat::kYuyv, CameraFormat::kNv12};
  EXPECT_EQ(start(setup).format, CameraFormat::kYuyv);
  setup.formats = {CameraFormat::kNv12, CameraFormat::kYuyv};
  EXPECT_EQ(start(setup).format, CameraFormat::kNv12);
  setup.formats = {CameraFormat::kMjpeg, CameraFormat::kBgr24};
  EXPECT_EQ(refusal(setup).cause, CameraCause::kUnsupported);
}

TEST_F(V4l2, CropsToWhatIsNeededAndBackAgain) {
  FakeV4l2Device device = numbered(0);
  device.width = 256;
  device.height = 128;
  calls_.add(device);
  CameraSetup setup;
  setup.width = 256;
  setup.height = 128;
  setup.crop = {90, 20, 100, 50};
  CameraMode mode = start(setup);
  EXPECT_EQ(mode.crop, (CameraArea{88, 16, 104, 56})) << "the device's step is 8";
  EXPECT_EQ(mode.width, 104);
  EXPECT_EQ(mode.height, 56);
  expect_picture(next(), 0);
  setup.crop = {200, 100, 1000, 1000};
  mode = start(setup);
  EXPECT_EQ(mode.crop, (CameraArea{200, 96, 56, 32})) << "no more than there is";
  setup.width = 128;
  setup.height = 64;
  setup.crop = {64, 32, 128, 64};
  mode = start(setup);
  EXPECT_EQ(mode.crop, setup.crop);
  EXPECT_EQ(mode.width, 64) << "half as many texels as the sensor's, cropped or not";
  EXPECT_EQ(mode.height, 32);
  setup.crop = {};
  mode = start(setup);
  EXPECT_EQ(mode.crop, (CameraArea{0, 0, 256, 128}));
  EXPECT_EQ(mode.width, 128);
}

TEST_F(V4l2, SendsEverythingWhereTheDeviceCannotCrop) {
  FakeV4l2Device device = numbered(0);
  device.can_crop = false;
  device.can_export = false;
  calls_.add(device);
  CameraSetup setup;
  setup.crop = {8, 8, 48, 16};
  const CameraMode mode = start(setup);
  EXPECT_EQ(mode.crop, (CameraArea{0, 0, 64, 48}));
  EXPECT_EQ(next().planes[0].dma_buf, -1);
}

TEST_F(V4l2, SetsTheRateWhereTheDeviceCan) {
  FakeV4l2Node& node = calls_.add(numbered(0));
  CameraSetup setup;
  setup.rate = 29.97;
  EXPECT_NEAR(start(setup).rate, 29.97, 1e-9);
  const nanoseconds first = next().captured_at;
  EXPECT_NEAR(static_cast<double>((next().captured_at - first).count()), 1e9 / 29.97, 2000.0);
  node.device().sets_rate = false;
  setup.rate = 50.0;
  EXPECT_NEAR(start(setup).rate, 29.97, 1e-9);
  setup.rate = 0.0;
  EXPECT_NEAR(start(setup).rate, 29.97, 1e-9);
}

TEST_F(V4l2, KnowsTheRateOfASignal) {
  FakeV4l2Device device = numbered(0);
  device.hdmi = true;
  device.rate = 50.0;
  FakeV4l2Node& node = calls_.add(device);
  CameraMode mode = start({});
  EXPECT_NEAR(mode.rate, 50.0, 0.01);
  node.change_signal(96, 54, 25.0);
  CameraFrame frame;
  CameraTrouble trouble;
  EXPECT_EQ(next(frame, trouble), CameraPoll::kLost);
  EXPECT_EQ(trouble.cause, CameraCause::kChanged);
  EXPECT_EQ(next(frame, trouble), CameraPoll::kLost) << "until it is started again";
  mode = start({});
  EXPECT_NEAR(mode.rate, 25.0, 0.01);
  EXPECT_EQ(mode.width, 96);
  EXPECT_EQ(mode.height, 54);
  expect_picture(next(), 0);
}

TEST_F(V4l2, LosesTheStreamWhenItEnds) {
  FakeV4l2Node& node = calls_.add(numbered(0));
  CameraFrame frame;
  CameraTrouble trouble;
  start({});
  node.send_event(V4L2_EVENT_EOS);
  EXPECT_EQ(next(frame, trouble), CameraPoll::kLost);
  EXPECT_STREQ(trouble.step, "end of stream");
  start({});
  node.end_stream();
  EXPECT_EQ(next(frame, trouble), CameraPoll::kFrame);
  EXPECT_EQ(next(frame, trouble), CameraPoll::kLost);
  EXPECT_EQ(trouble.error, EPIPE);
}

TEST_F(V4l2, SaysThatTheSignalIsGoneWhenItIs) {
  for (const bool hdmi : {false, true}) {
    FakeV4l2 calls(clock_);
    FakeV4l2Device device = numbered(0);
    device.hdmi = hdmi;
    FakeV4l2Node& node = calls.add(device);
    V4l2Camera camera(calls, clock_);
    ASSERT_TRUE(std::holds_alternative<CameraMode>(camera.start({})));
    node.begin_fault(CameraFault::kNoSignal, 0);
    CameraFrame frame;
    CameraTrouble trouble;
    EXPECT_EQ(camera.poll(frame, trouble), CameraPoll::kLost);
    EXPECT_EQ(trouble.cause, CameraCause::kNoSignal);
    const auto started = camera.start({});
    ASSERT_TRUE(std::holds_alternative<CameraTrouble>(started));
    EXPECT_EQ(std::get<CameraTrouble>(started).cause, CameraCause::kNoSignal);
  }
}

TEST_F(V4l2, TakesASignalThatCannotBeReadForNone) {
  FakeV4l2Device device = numbered(0);
  device.hdmi = true;
  calls_.add(device);
  for (const int error : {ENOLINK, ENOLCK, ERANGE}) {
    calls_.fail(VIDIOC_QUERY_DV_TIMINGS, 1, error, false);
    EXPECT_EQ(refusal({}).cause, CameraCause::kNoSignal) << error;
  }
}

TEST_F(V4l2, HandsShortFramesBackAsDamaged) {
  for (const CameraFault fault : {CameraFault::kShort, CameraFault::kDamaged}) {
    FakeV4l2 calls(clock_);
    FakeV4l2Node& node = calls.add(numbered(0));
    V4l2Camera camera(calls, clock_);
    ASSERT_TRUE(std::holds_alternative<CameraMode>(camera.start({})));
    node.begin_fault(fault, 100);
    CameraFrame frame;
    CameraTrouble trouble;
    for (std::uint64_t i = 0; i < 10; ++i) {
      clock_.advance(16'666'667ns);
      ASSERT_EQ(camera.poll(frame, trouble), CameraPoll::kDamaged);
      EXPECT_EQ(frame.sequence, i);
    }
    clock_.advance(17ms);
    calls.fail(VIDIOC_QBUF, 1, EIO, false);
    EXPECT_EQ(camera.poll(frame, trouble), CameraPoll::kDamaged);
    EXPECT_EQ(camera.poll(frame, trouble), CameraPoll::kLost) << "it could not be handed back";
    EXPECT_STREQ(trouble.step, "VIDIOC_QBUF");
  }
}

TEST_F(V4l2, RefusesRowsAndBuffersThatAreTooShort) {
  for (const Wire& wire : kWires) {
    FakeV4l2Device device = numbered(0);
    device.fourccs = {wire.fourcc};
    device.multi_planar = wire.multi_planar;
    FakeV4l2 calls(clock_);
    FakeV4l2Node& node = calls.add(device);
    V4l2Camera camera(calls, clock_);
    node.device().missing_bytes = 1;
    auto started = camera.start({});
    ASSERT_TRUE(std::holds_alternative<CameraTrouble>(started));
    EXPECT_EQ(std::get<CameraTrouble>(started).cause, CameraCause::kChanged);
    node.device().missing_bytes = 0;
    if (!wire.multi_planar && wire.format != CameraFormat::kMjpeg) {
      node.device().missing_image_bytes = 1;
      EXPECT_TRUE(std::holds_alternative<CameraTrouble>(camera.start({})));
      node.device().missing_image_bytes = 0;
    }
    if (wire.format == CameraFormat::kMjpeg) continue;
    node.begin_fault(CameraFault::kWrongStride, 0);
    started = camera.start({});
    ASSERT_TRUE(std::holds_alternative<CameraTrouble>(started));
    EXPECT_EQ(std::get<CameraTrouble>(started).cause, CameraCause::kChanged);
    EXPECT_EQ(calls.complaints(), "");
  }
}

TEST_F(V4l2, RefusesADriverWithOneBuffer) {
  FakeV4l2Device device = numbered(0);
  device.most_buffers = 1;
  calls_.add(device);
  EXPECT_EQ(refusal({}).cause, CameraCause::kFailed);
}

TEST_F(V4l2, LosesADriverThatInventsBuffers) {
  FakeV4l2Device device = numbered(0);
  device.numbers_buffers = false;
  calls_.add(device);
  start({});
  CameraFrame frame;
  CameraTrouble trouble;
  EXPECT_EQ(next(frame, trouble), CameraPoll::kLost);
  EXPECT_EQ(trouble.cause, CameraCause::kFailed);
}

TEST_F(V4l2, StampsFramesOfDriversThatDoNot) {
  FakeV4l2Device device = numbered(0);
  device.stamps = false;
  calls_.add(device);
  start({});
  for (int i = 0; i < 3; ++i) {
    const CameraFrame frame = next();
    EXPECT_EQ(frame.captured_at, clock_.now());
    camera_.give_back(frame);
  }
}

TEST_F(V4l2, TakesAsManyBuffersAsTheDriverInsistsOn) {
  FakeV4l2Device device = numbered(0);
  device.least_buffers = 7;
  calls_.add(device);
  CameraSetup setup;
  setup.buffers = 2;
  start(setup);
  for (int i = 0; i < 7; ++i) expect_picture(next(), 0);
  for (const int buffers : {-1, 0, 1, 33}) {
    setup.buffers = buffers;
    EXPECT_EQ(refusal(setup).cause, CameraCause::kUnsupported);
  }
}

TEST_F(V4l2, RefusesHalfFrames) {
  for (const __u32 field : {V4L2_FIELD_ALTERNATE, V4L2_FIELD_TOP, V4L2_FIELD_SEQ_TB}) {
    FakeV4l2 calls(clock_);
    FakeV4l2Device device = numbered(0);
    device.field = field;
    calls.add(device);
    V4l2Camera camera(calls, clock_);
    EXPECT_TRUE(std::holds_alternative<CameraTrouble>(camera.start({})));
  }
}

TEST_F(V4l2, KnowsItsColours) {
  FakeV4l2Node& node = calls_.add(numbered(0));
  EXPECT_TRUE(start({}).bt709);
  EXPECT_FALSE(start({}).full_range);
  node.device().colorspace = V4L2_COLORSPACE_SMPTE170M;
  EXPECT_FALSE(start({}).bt709);
  node.device().colorspace = V4L2_COLORSPACE_JPEG;
  EXPECT_TRUE(start({}).full_range);
}

FakeV4l2Device controlled() {
  FakeV4l2Device device = numbered(0);
  device.controls = {
      {V4L2_CID_AUTO_WHITE_BALANCE, "White Balance, Automatic", V4L2_CTRL_TYPE_BOOLEAN, 0, 1, 1, {}},
      {V4L2_CID_WHITE_BALANCE_TEMPERATURE,
       "White Balance Temperature",
       V4L2_CTRL_TYPE_INTEGER,
       2800,
       6500,
       4000,
       {}},
      {V4L2_CID_EXPOSURE_AUTO,
       "Auto Exposure",
       V4L2_CTRL_TYPE_MENU,
       0,
       3,
       3,
       {V4L2_EXPOSURE_AUTO, V4L2_EXPOSURE_SHUTTER_PRIORITY}},
      {V4L2_CID_EXPOSURE_ABSOLUTE, "Exposure Time, Absolute", V4L2_CTRL_TYPE_INTEGER, 1, 5000, 157, {}},
      {V4L2_CID_ANALOGUE_GAIN, "Analogue Gain", V4L2_CTRL_TYPE_INTEGER, 16, 256, 16, {}},
      {V4L2_CID_GAIN, "Gain", V4L2_CTRL_TYPE_INTEGER, 0, 100, 0, {}},
      {V4L2_CID_USER_BASE + 0x1234, "External Trigger Mode", V4L2_CTRL_TYPE_MENU, 0, 1, 0, {}},
      {V4L2_CID_USER_BASE + 0x1235, "Sensor Clock (Hz)", V4L2_CTRL_TYPE_INTEGER64, 0, 1LL << 40, 0, {}},
      {V4L2_CID_USER_BASE + 0x1236, "Serial", V4L2_CTRL_TYPE_STRING, 0, 8, 0, {}},
  };
  return device;
}

TEST_F(V4l2, SetsControlsInTheDriversUnits) {
  FakeV4l2Node& node = calls_.add(controlled());
  CameraSetup setup;
  setup.controls = {{"exposure", 12345.0},
                    {"gain", 2.5},
                    {"white_balance", 5600.0},
                    {"auto_exposure", 0.0},
                    {"auto_white_balance", 0},
                    {"trigger", 1.0},
                    {"Gain", 50.0},
                    {"sensor_clock_hz", 5e9}};
  start(setup);
  EXPECT_EQ(node.control("Exposure Time, Absolute"), 123);
  EXPECT_EQ(node.control("Analogue Gain"), 40);
  EXPECT_EQ(node.control("White Balance Temperature"), 5600);
  EXPECT_EQ(node.control("Auto Exposure"), V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(node.control("White Balance, Automatic"), 0);
  EXPECT_EQ(node.control("External Trigger Mode"), 1);
  EXPECT_EQ(node.control("Gain"), 50);
  EXPECT_EQ(node.control("Sensor Clock (Hz)"), 5'000'000'000);
  setup.controls = {{"auto_exposure", 1.0}, {"auto_white_balance", 1.0}};
  start(setup);
  EXPECT_EQ(node.control("Auto Exposure"), V4L2_EXPOSURE_APERTURE_PRIORITY) << "it has no full automatic";
  EXPECT_EQ(node.control("White Balance, Automatic"), 1);
}

TEST_F(V4l2, SetsControlsWhileItStreamsToTheNearestThatTheDriverHas) {
  FakeV4l2Node& node = calls_.add(controlled());
  EXPECT_FALSE(camera_.set_control({"exposure", 12345.0})) << "it is stopped";
  start({});
  EXPECT_TRUE(camera_.set_control({"auto_exposure", 0.0}));
  EXPECT_TRUE(camera_.set_control({"exposure", 12345.0}));
  EXPECT_EQ(node.control("Exposure Time, Absolute"), 123);
  EXPECT_TRUE(camera_.set_control({"exposure", 3.0}));
  EXPECT_EQ(node.control("Exposure Time, Absolute"), 1);
  EXPECT_TRUE(camera_.set_control({"gain", 99.0}));
  EXPECT_EQ(node.control("Analogue Gain"), 256);
  EXPECT_FALSE(camera_.set_control({"frame_time", 16667.0}));
  EXPECT_FALSE(camera_.set_control({"gain", 0.0 / 0.0}));
}

TEST_F(V4l2, RefusesControlsAndValuesThatTheDriverHasNot) {
  FakeV4l2Node& node = calls_.add(controlled());
  const std::vector<CameraControl> wrong = {
      {"exposure", 0.0},       {"exposure", 1e9},        {"gain", 0.5},
      {"gain", 100.0},         {"white_balance", 100.0}, {"sharpness", 1},
      {"Gain", 101.0},         {"gain_", 1.0},           {"", 0.0},
      {"serial", 1.0},         {"Gain", -1.0},           {"exposure", -1e99},
      {"exposure", 0.0 / 0.0},
  };
  CameraSetup setup;
  for (const CameraControl& control : wrong) {
    setup.controls = {control};
    EXPECT_EQ(refusal(setup).cause, CameraCause::kUnsupported) << control.name << " " << control.value;
  }
  // A gain from 0 does not say which is none.
  std::erase_if(node.device().controls,
                [](const auto& control) { return control.id == V4L2_CID_ANALOGUE_GAIN; });
  setup.controls = {{"gain", 1.0}};
  EXPECT_EQ(refusal(setup).cause, CameraCause::kUnsupported);
  EXPECT_STREQ(refusal(setup).step, "gain");
}

TEST_F(V4l2, SetsAutomaticsBeforeValues) {
  FakeV4l2Node& node = calls_.add(controlled());
  CameraSetup setup;
  setup.controls = {{"exposure", 12300.0}, {"auto_exposure", 0.0}};
  calls_.fail(VIDIOC_S_EXT_CTRLS, 2, EIO, false);
  refusal(setup);
  EXPECT_EQ(node.control("Auto Exposure"), V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(node.control("Exposure Time, Absolute"), 157);
}

}  // namespace
}  // namespace cupola
