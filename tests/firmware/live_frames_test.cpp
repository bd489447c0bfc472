// Live shows on fake cameras, a fake display and a fake clock: latency, faults, and what the others show
// meanwhile. SPDX-License-Identifier: MIT
#include "firmware/live_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>

#include "firmware/frame_loop.h"
#include "firmware/show.h"
#include "hal/camera/fake_camera.h"
#include "hal/display/fake_display.h"
#include "pipeline/frame/error.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using Words = std::vector<std::uint32_t>;

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr Size kFace{48, 48};
constexpr std::array<const char*, 4> kViews = {"front", "left", "right", "top"};
constexpr nanoseconds kPeriod = 16'666'666ns;

Rig small_rig() {
  const std::string lines[] = {"frame.width=64", "frame.height=48", "frame.center=[32, 24]",
                               "frame.radius=30"};
  return load_named_rig("omnimax", lines);
}

// Shows frames and lets the test see each.
class SeenDisplay final : public Display {
 public:
  SeenDisplay(Clock& clock, std::function<void(int, DisplayBuffer)> see)
      : fake_(clock, kWidth, kHeight), see_(std::move(see)) {}
  DisplayBuffer back_buffer() noexcept override { return fake_.back_buffer(); }
  Presented present(nanoseconds when) noexcept override { return seen(fake_.present(when)); }
  Presented repeat(nanoseconds when) noexcept override { return seen(fake_.repeat(when)); }
  nanoseconds period() const noexcept override { return fake_.period(); }
  const char* trouble() const noexcept override { return fake_.trouble(); }

 private:
  Presented seen(Presented presented) noexcept {
    if (see_) see_(flips_++, fake_.front_buffer());
    return presented;
  }
  FakeDisplay fake_;
  std::function<void(int, DisplayBuffer)> see_;
  int flips_ = 0;
};

class LiveShow {
 public:
  // `adjust` may change each camera's device and setup before it is made.
  explicit LiveShow(const std::function<void(std::size_t, FakeCameraDevice&, CameraSetup&)>& adjust = {}) {
    std::vector<OpenCamera> cameras;
    for (std::size_t c = 0; c < kViews.size(); ++c) {
      FakeCameraDevice device;
      device.number = static_cast<int>(c);
      device.formats = {CameraFormat::kNv12};
      device.width = kFace.width;
      device.height = kFace.height;
      device.latency = 4ms;
      OpenCamera open;
      open.settings.view = kViews[c];
      open.settings.patience = 100ms;
      open.settings.setup.width = kFace.width;
      open.settings.setup.height = kFace.height;
      open.settings.setup.formats = {CameraFormat::kNv12};
      if (adjust) adjust(c, device, open.settings.setup);
      auto camera = std::make_unique<FakeCamera>(clock, device);
      fakes.push_back(camera.get());
      open.device = std::move(camera);
      cameras.push_back(std::move(open));
    }
    frames = std::make_unique<LiveFrames>(small_rig(), std::move(cameras), SyncSettings{}, best_cpu(), pool,
                                          clock);
  }

  LoopCounts play(nanoseconds time, std::function<void(int, DisplayBuffer)> see = {}) {
    SeenDisplay display(clock, std::move(see));
    FrameLoop loop(*frames, display, clock, pool);
    EXPECT_EQ(loop.run(time), LoopEnd::kTimeUp);
    return loop.counts();
  }

  FakeClock clock;
  WorkerPool pool{1};
  std::vector<FakeCamera*> fakes;
  std::unique_ptr<LiveFrames> frames;
};

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
  const auto warp = make_yuv_to_xrgb_warp(rig, YuvLayout::kNv12, best_cpu(), pool);
  std::array<ImageBuffer, 2> made;
  for (std::size_t i = 0; i < 2; ++i) {
    std::vector<YuvBuffer> faces;
    std::vector<YuvImage> images;
    for (std::size_t v = 0; v < kViews.size(); ++v) {
      faces.emplace_back(YuvLayout::kNv12, YuvColour{}, kFace);
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

// Faults that leave a camera without a picture for a while, on one to four cameras.
class LiveFault : public testing::TestWithParam<CameraFault> {};

TEST_P(LiveFault, LeavesTheOtherFacesAsTheyWouldHaveBeen) {
  constexpr nanoseconds kFrom = 1s;
  constexpr nanoseconds kUntil = 2s;
  std::vector<Words> undisturbed;
  LiveShow calm;
  calm.play(3s, [&](int, DisplayBuffer buffer) { undisturbed.push_back(words_of(buffer)); });
  for (std::size_t faulty = 1; faulty <= 4; ++faulty) {
    LiveShow show([&](std::size_t c, FakeCameraDevice& device, CameraSetup&) {
      if (c < faulty) device.faults = {{GetParam(), kFrom, kUntil}};
    });
    std::vector<std::vector<bool>> without;
    for (std::size_t c = 0; c < faulty; ++c) without.push_back(pixels_without(c));
    std::int64_t compared = 0;
    bool differed = false;
    show.play(3s, [&](int flip, DisplayBuffer buffer) {
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
    for (std::size_t c = 0; c < 4; ++c) {
      const CameraCounts& counts = show.frames->watch(c).counts();
      EXPECT_EQ(counts.losses, c < faulty ? 1U : 0U) << c;
      EXPECT_EQ(show.frames->faces().sync().faces()[c].state, SyncedFace::State::kInStep) << "back again";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Faults, LiveFault,
                         testing::Values(CameraFault::kUnplugged, CameraFault::kSilent,
                                         CameraFault::kWrongStride),
                         [](const auto& fault) {
                           return std::string(fault.param == CameraFault::kUnplugged ? "Unplugged"
                                              : fault.param == CameraFault::kSilent  ? "Silent"
                                                                                     : "WrongStride");
                         });

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
  const auto grey = [](std::size_t, FakeCameraDevice& device, CameraSetup& setup) {
    setup.formats.clear();
    device.formats = {CameraFormat::kGrey};
  };
  EXPECT_THROW(LiveShow{grey}, Failure);
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
