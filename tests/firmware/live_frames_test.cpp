// Live shows on fake devices: latency, faults, and what the others show meanwhile.
// SPDX-License-Identifier: MIT
#include "firmware/live_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "hal/camera/recorded_camera.h"
#include "hal/camera/recording_camera.h"
#include "pipeline/frame/error.h"
#include "tests/firmware/live_show.h"
#include "tests/frame/temporary_folder.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using Words = std::vector<std::uint32_t>;

using namespace test;

constexpr nanoseconds kPeriod = 16'666'666ns;

Words words_of(const DisplayBuffer& buffer) {
  Words words(static_cast<std::size_t>(buffer.width) * static_cast<std::size_t>(buffer.height));
  for (int y = 0; y < buffer.height; ++y) {
    std::memcpy(&words[static_cast<std::size_t>(y) * static_cast<std::size_t>(buffer.width)],
                buffer.data + y * buffer.stride, std::size_t{4} * static_cast<std::size_t>(buffer.width));
  }
  return words;
}

// True where view `view` has no part in the pixel: nor, lest a part too small to show here be overlooked, in
// those beside it.
std::vector<bool> pixels_without(std::size_t view) {
  Rig rig = small_rig();
  const std::vector<Size> sizes(kViews.size(), kFace);
  set_view_sizes(rig, sizes);
  WorkerPool pool(1);
  const auto warp = make_native_to_xrgb_warp(rig, NativeLayout::kNv12, best_cpu(), pool);
  std::array<ImageBuffer, 2> made;
  for (std::size_t i = 0; i < 2; ++i) {
    std::vector<NativeBuffer> faces;
    std::vector<NativeImage> images;
    for (std::size_t v = 0; v < kViews.size(); ++v) {
      faces.emplace_back(NativeLayout::kNv12, YuvColour{}, kFace);
      for (int y = 0; y < kFace.height; ++y) {
        for (int x = 0; x < kFace.width; ++x) {
          *sample_at(faces.back().pixels(), 0, x, y) =
              static_cast<std::uint8_t>(v == view && i == 1 ? 235 : 16);
        }
      }
      images.push_back(as_const(faces.back().pixels()));
    }
    made[i] = ImageBuffer(PixelFormat::kXrgb8888, {kWidth, kHeight});
    warp->warp(images, made[i].pixels());
  }
  const auto differs = [&](int x, int y) {
    return x >= 0 && x < kWidth && y >= 0 && y < kHeight &&
           made[0].pixels().samples<std::uint32_t>(0, y)[x] !=
               made[1].pixels().samples<std::uint32_t>(0, y)[x];
  };
  std::vector<bool> without;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      bool has_part = false;
      for (int i = 0; i < 9; ++i) has_part = has_part || differs(x + i % 3 - 1, y + i / 3 - 1);
      without.push_back(!has_part);
    }
  }
  return without;
}

TEST(LiveFrames, ReachTheScreenWithinAPeriodWithoutACopyOrAnAllocation) {
  LiveShow show([](std::size_t, FakeCameraDevice& device, CameraSetup&) { device.jitter = 1ms; });
  const LoopCounts counts = show.play(60s);
  EXPECT_NEAR(static_cast<double>(counts.frames_presented), 3600.0, 1.0);
  EXPECT_EQ(counts.heap_allocations, 0);
  EXPECT_EQ(counts.pixel_bytes_copied, 0);
  EXPECT_EQ(show.frames->faces().counts().pixel_bytes_copied, 0U);
  std::vector<double> latencies = show.frames->latencies_ms();
  ASSERT_GT(latencies.size(), 3400U);
  std::sort(latencies.begin(), latencies.end());
  // Transport 4 ms, a jitter of 1 ms, and the flip is chosen for a millisecond before it.
  EXPECT_LE(latencies[latencies.size() / 2], 1e-6 * static_cast<double>(kPeriod.count()) + 6.0);
  EXPECT_GT(show.frames->faces().sync().counts().whole * 100, show.frames->faces().sync().counts().sets * 95);
}

Rig overlapping_rig() {
  Rig rig = small_rig();
  for (View& view : rig.views) view.focal = {0.35, 0.35};
  rig.seams.feather_deg = 6.0;
  return rig;
}

// One camera is locked and dark: the others go where it is.
TEST(LiveFrames, MatchTheirColoursWithoutAnAllocation) {
  LiveColours colours{.match = true, .locked = {}};
  colours.locked[0] = ViewColour{{0.7, 0.7, 0.7}, {0.0, 0.0, 0.0}};
  LiveShow show({}, overlapping_rig(), {}, colours);
  const LoopCounts counts = show.play(60s);
  EXPECT_EQ(counts.heap_allocations, 0);
  ShowReport report;
  show.frames->report(report);
  ASSERT_TRUE(report.cameras[0].colour && report.cameras[1].colour);
  EXPECT_EQ(*report.cameras[0].colour, *colours.locked[0]);
  EXPECT_LT(report.cameras[1].colour->of(1, 100.0), 97.0);
}

// Its pictures are grey, as bright as a light and what it is told make them.
class LitCamera final : public Camera {
 public:
  LitCamera(std::unique_ptr<Camera> device, const double& light)
      : device_(std::move(device)), light_(light) {}

  std::variant<CameraMode, CameraTrouble> start(const CameraSetup& setup) noexcept override {
    told = {10000.0, 1.0};
    return device_->start(setup);
  }
  void stop() noexcept override { device_->stop(); }
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept override {
    const CameraPoll polled = device_->poll(frame, trouble);
    if (polled != CameraPoll::kFrame) return polled;
    const double level = std::min(1.0, std::pow(light_ * told.us * told.gain / 10000.0, 1.0 / 2.2));
    texels_.assign(static_cast<std::size_t>(frame.planes[0].stride * frame.height),
                   static_cast<std::uint8_t>(16.5 + 219.0 * level));
    frame.planes[0].data = texels_.data();
    return polled;
  }
  void give_back(const CameraFrame& frame) noexcept override { device_->give_back(frame); }
  int descriptor() const noexcept override { return device_->descriptor(); }
  bool set_control(const CameraControl& control) noexcept override {
    (control.name == "gain" ? told.gain : told.us) = control.value;
    return device_->set_control(control);
  }

  Exposure told;

 private:
  std::unique_ptr<Camera> device_;
  const double& light_;
  std::vector<std::uint8_t> texels_;
};

TEST(LiveFrames, AreExposedAlikeAlsoAfterACameraCameBack) {
  double light = 4.0;
  std::array<LitCamera*, 4> cameras{};
  LiveShow show({}, small_rig(),
                [&](std::size_t c, std::unique_ptr<Camera> fake, FakeClock&) {
                  auto lit = std::make_unique<LitCamera>(std::move(fake), light);
                  cameras[c] = lit.get();
                  return lit;
                },
                {}, {.sync = {}, .align = false, .match_colours = false, .exposure = ExposureLimits()});
  const auto expect_alike = [&] {
    ShowReport report;
    show.frames->report(report);
    ASSERT_TRUE(report.exposure);
    EXPECT_NEAR(report.exposure->brightness, 0.45, 0.03);
    for (const LitCamera* camera : cameras) EXPECT_EQ(camera->told, report.exposure->told);
  };
  show.play(15s);
  expect_alike();
  EXPECT_NEAR(cameras[0]->told.us, 10000.0 * std::pow(0.45, 2.2) / 4.0, 50.0);
  show.fakes[2]->begin_fault(CameraFault::kUnplugged);
  light = 0.1;
  show.play(1s);
  show.fakes[2]->end_faults();
  const LoopCounts counts = show.play(15s);
  expect_alike();
  EXPECT_GT(cameras[2]->told.gain, 1.0) << "the light has gone";
  EXPECT_EQ(counts.frames_failed, 0);
}

// Their clocks are a tenth of a per mille and more apart: in a minute they would be 10 ms.
TEST(LiveFrames, AreAlignedWhereTheCamerasTakeAFrameTime) {
  const auto worst_ms = [](bool align) {
    LiveShow show([](std::size_t c, FakeCameraDevice& device,
                     CameraSetup&) { device.drift_ppm = 120.0 * static_cast<double>(c) - 150.0; },
                  small_rig(), {}, {},
                  {.sync = {.tolerance = 8333us}, .align = align, .match_colours = false, .exposure = {}});
    show.play(60s);
    double worst = 0.0;
    for (int second = 0; second < 10; ++second) {
      show.play(1s);
      for (std::size_t v = 1; v < 4; ++v) {
        const auto offset = show.frames->faces().sync().offset(v).offset;
        worst = std::max(worst, 1e-6 * std::abs(static_cast<double>(offset.count())));
      }
    }
    return worst;
  };
  EXPECT_GT(worst_ms(false), 4.0);
  EXPECT_LT(worst_ms(true), 0.3);
}

TEST(LiveFrames, RefuseToMatchPicturesThatOnlyMeet) {
  try {
    LiveShow({}, small_rig(), {}, {.match = true, .locked = {}});
    FAIL();
  } catch (const Failure& failure) {
    EXPECT_NE(std::string(failure.what()).find("colour.match: no two views overlap"), std::string::npos);
  }
}

TEST(LiveFrames, GiveCamerasTheColoursThatAreLocked) {
  const auto brightness = [](const LiveColours& colours) {
    LiveShow show({}, overlapping_rig(), {}, colours);
    std::uint64_t sum = 0;
    show.play(1s, [&](int, DisplayBuffer buffer) {
      sum = 0;
      for (const std::uint32_t word : words_of(buffer)) sum += word & 0xff;
    });
    return static_cast<double>(sum);
  };
  LiveColours dark;
  for (auto& colour : dark.locked) colour = ViewColour{{0.5, 0.5, 0.5}, {0.0, 0.0, 0.0}};
  EXPECT_NEAR(brightness(dark) / brightness({}), 0.5, 0.02);
}

// Faults that leave a camera without a picture for a while, on one to four cameras.
class LiveFault : public testing::TestWithParam<CameraFault> {};

TEST_P(LiveFault, LeavesTheOtherFacesAsTheyWouldHaveBeen) {
  constexpr nanoseconds kFrom = 1s;
  constexpr nanoseconds kUntil = 2s;
  std::vector<Words> undisturbed;
  LiveShow calm;
  calm.play(3s, [&](int, DisplayBuffer buffer) { undisturbed.push_back(words_of(buffer)); });
  std::int64_t skipped = 0;
  for (std::size_t faulty = 1; faulty <= 4; ++faulty) {
    LiveShow show([&](std::size_t c, FakeCameraDevice& device, CameraSetup&) {
      if (c < faulty) device.faults = {{GetParam(), kFrom, kUntil}};
    });
    std::vector<std::vector<bool>> without;
    for (std::size_t c = 0; c < faulty; ++c) without.push_back(pixels_without(c));
    std::int64_t compared = 0;
    bool differed = false;
    const LoopCounts loop = show.play(3s, [&](int flip, DisplayBuffer buffer) {
      const Words words = words_of(buffer);
      const Words& expected = undisturbed[static_cast<std::size_t>(flip)];
      for (std::size_t i = 0; i < words.size(); ++i) {
        const bool others =
            std::all_of(without.begin(), without.end(), [&](const auto& part) { return part[i]; });
        differed = differed || words[i] != expected[i];
        if (!others) continue;
        ++compared;
        ASSERT_EQ(words[i], expected[i]) << "flip " << flip << " pixel " << i;
      }
    });
    EXPECT_GT(compared, 10'000);
    EXPECT_TRUE(differed) << "the fault was seen";
    skipped += loop.tiles.skipped;
    for (std::size_t c = 0; c < 4; ++c) {
      const CameraCounts& counts = show.frames->cameras()[c].watch->counts();
      EXPECT_EQ(counts.losses, c < faulty ? 1U : 0U) << c;
      EXPECT_EQ(show.frames->faces().sync().faces()[c].state, SyncedFace::State::kInStep) << "back again";
    }
  }
  EXPECT_GT(skipped, 0) << "tiles of the last picture, or of the slate, are not warped again";
}

INSTANTIATE_TEST_SUITE_P(Faults, LiveFault,
                         testing::Values(CameraFault::kUnplugged, CameraFault::kSilent,
                                         CameraFault::kWrongStride),
                         [](const auto& fault) {
                           return std::string(fault.param == CameraFault::kUnplugged ? "Unplugged"
                                              : fault.param == CameraFault::kSilent  ? "Silent"
                                                                                     : "WrongStride");
                         });

// An incident as a test: what was recorded of it comes out of the same path, flip for flip.
TEST(LiveFrames, OfARecordingAreThoseThatWereRecordedToTheBit) {
  const auto trouble = [](std::size_t c, FakeCameraDevice& device, CameraSetup&) {
    device.jitter = 1ms;
    device.drift_ppm = 40.0 * static_cast<double>(c);
    device.crop = FakeCrop::kCuts;
    device.faults = {{CameraFault::kDropped, 0ns, nanoseconds::max(), 7}};
    if (c == 1) device.faults.push_back({CameraFault::kUnplugged, 1s, 1500ms});
    if (c == 2) device.faults.push_back({CameraFault::kSilent, 1200ms, 1700ms});
    if (c == 3) device.faults.push_back({CameraFault::kWrongStride, 2s, 2100ms});
  };
  const TemporaryFolder folder;
  const auto file_of = [&](std::size_t c) { return folder / kViews[c]; };
  std::vector<Words> live;
  {
    LiveShow show(trouble, small_rig(), [&](std::size_t c, std::unique_ptr<Camera> camera, FakeClock& clock) {
      return std::make_unique<RecordingCamera>(
          std::move(camera), clock, 0ns,
          std::make_unique<CameraRecorder>(file_of(c), CameraRecorder::Writing::kAtOnce));
    });
    const LoopCounts counts =
        show.play(3s, [&](int, DisplayBuffer buffer) { live.push_back(words_of(buffer)); });
    EXPECT_EQ(counts.pixel_bytes_copied, 0);
    EXPECT_EQ(show.frames->cameras()[1].watch->counts().losses, 1U);
  }
  ReplayTime time;
  LiveShow show({}, small_rig(), [&](std::size_t c, std::unique_ptr<Camera>, FakeClock& clock) {
    return std::make_unique<RecordedCamera>(clock, time, file_of(c));
  });
  std::vector<Words> again;
  show.play(3s, [&](int, DisplayBuffer buffer) { again.push_back(words_of(buffer)); });
  EXPECT_EQ(again, live);
  EXPECT_EQ(live.size(), 180U);
}

TEST(LiveFrames, CropCamerasToWhatTheWarpLooksAtAndShowTheSame) {
  std::vector<Words> whole;
  LiveShow reference;
  reference.play(1s, [&](int, DisplayBuffer buffer) { whole.push_back(words_of(buffer)); });
  LiveShow show([](std::size_t, FakeCameraDevice& device, CameraSetup&) { device.crop = FakeCrop::kCuts; });
  show.play(1s, [&](int flip, DisplayBuffer buffer) {
    ASSERT_EQ(words_of(buffer), whole[static_cast<std::size_t>(flip)]) << flip;
  });
  int cropped = 0;
  for (const OpenCamera& camera : show.frames->cameras()) {
    const CameraMode& mode = camera.watch->mode();
    cropped += mode.width * mode.height * 8 <= 7 * kFace.width * kFace.height ? 1 : 0;
    EXPECT_EQ(camera.watch->counts().losses, 0U);
  }
  EXPECT_GE(cropped, 3) << "half of left, right and top is behind the audience";
}

TEST(LiveFrames, KeepTheLastPictureOfACroppedCamera) {
  std::vector<Words> whole;
  const auto unplugged = [](std::size_t c, FakeCameraDevice& device, CameraSetup&) {
    if (c == 1) device.faults = {{CameraFault::kUnplugged, 1s, 2s}};
  };
  LiveShow reference(unplugged);
  reference.play(3s, [&](int, DisplayBuffer buffer) { whole.push_back(words_of(buffer)); });
  LiveShow show([&](std::size_t c, FakeCameraDevice& device, CameraSetup& setup) {
    unplugged(c, device, setup);
    device.crop = FakeCrop::kCuts;
  });
  show.play(3s, [&](int flip, DisplayBuffer buffer) {
    ASSERT_EQ(words_of(buffer), whole[static_cast<std::size_t>(flip)]) << flip;
  });
  EXPECT_GT(show.frames->pixel_bytes_copied(), 0);
  EXPECT_LT(show.frames->pixel_bytes_copied(), reference.frames->pixel_bytes_copied());
}

TEST(LiveFrames, TakeWholePicturesFromCamerasThatZoomInsteadOfCropping) {
  LiveShow show([](std::size_t c, FakeCameraDevice& device, CameraSetup&) {
    device.crop = c % 2 == 0 ? FakeCrop::kZooms : FakeCrop::kCuts;
  });
  show.play(1s);
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_EQ(show.frames->faces().sync().faces()[c].state, SyncedFace::State::kInStep) << c;
    const CameraArea& crop = show.frames->cameras()[c].watch->mode().crop;
    EXPECT_TRUE(c % 2 == 1 || crop == (CameraArea{0, 0, kFace.width, kFace.height})) << c;
  }
  EXPECT_EQ(show.frames->faces().counts().unlike, 0U);
}

TEST(LiveFrames, StopCamerasThatTheWarpDoesNotLookAt) {
  const std::string left_edge[] = {"frame.width=64", "frame.height=48", "frame.center=[94, 24]",
                                   "frame.radius=40"};
  LiveShow show({}, load_named_rig("omnimax", left_edge));
  show.play(1s);
  const auto state = [&](std::size_t view) { return show.frames->faces().sync().faces()[view].state; };
  EXPECT_EQ(state(1), SyncedFace::State::kInStep) << "left";
  EXPECT_EQ(state(2), SyncedFace::State::kSlate) << "right";
  EXPECT_EQ(show.frames->cameras()[2].watch->descriptor(), -1) << "it does not stream";
  EXPECT_EQ(show.frames->cameras()[2].watch->counts().frames, 0U);
  EXPECT_GT(show.frames->cameras()[1].watch->counts().frames, 50U);
}

TEST(LiveFrames, GoOnFromSlatesWhenNoCameraIsThereAtFirst) {
  LiveShow show([](std::size_t, FakeCameraDevice& device, CameraSetup&) {
    device.faults = {{CameraFault::kUnplugged, 0ns, 10s}};
  });
  const LoopCounts counts = show.play(12s);
  EXPECT_GT(counts.frames_presented, 700);
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_EQ(show.frames->faces().sync().faces()[c].state, SyncedFace::State::kInStep);
  }
}

TEST(LiveFrames, RefuseCamerasThatDoNotSendTheSame) {
  const auto yuyv = [](std::size_t c, FakeCameraDevice& device, CameraSetup& setup) {
    setup.formats.clear();
    if (c == 1) device.formats = {CameraFormat::kYuyv};
  };
  EXPECT_THROW(LiveShow{yuyv}, Failure);
  const auto bgr = [](std::size_t c, FakeCameraDevice& device, CameraSetup& setup) {
    setup.formats.clear();
    device.formats = {c == 1 ? CameraFormat::kBgr24 : CameraFormat::kRgb24};
  };
  EXPECT_THROW(LiveShow{bgr}, Failure);
}

TEST(LiveFrames, ShowRgbAndTenBitsAsTheCamerasSendThem) {
  for (const CameraFormat format :
       {CameraFormat::kP010, CameraFormat::kRgb24, CameraFormat::kBgr24, CameraFormat::kXrgb32}) {
    LiveShow show([&](std::size_t, FakeCameraDevice& device, CameraSetup& setup) {
      device.formats = {format};
      setup.formats = {format};
    });
    const LoopCounts counts = show.play(1s);
    EXPECT_GT(counts.frames_presented, 50);
    EXPECT_EQ(counts.heap_allocations, 0);
    EXPECT_EQ(show.frames->pixel_bytes_copied(), 0);
  }
}

TEST(LiveFrames, RefuseAMissingCameraOfWhichNothingIsKnown) {
  const auto missing = [](std::size_t c, FakeCameraDevice& device, CameraSetup& setup) {
    if (c != 3) return;
    device.faults = {{CameraFault::kUnplugged}};
    setup.width = 0;
  };
  EXPECT_THROW(LiveShow{missing}, Failure);
}

}  // namespace
}  // namespace cupola
