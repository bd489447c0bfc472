// The whole way of a picture in a virtual machine: vivid's cameras, the warp, vkms' screen, read back and
// compared with the same faces warped by the scalar kernels.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "firmware/frame_loop.h"
#include "firmware/live_frames.h"
#include "firmware/open_cameras.h"
#include "firmware/show.h"
#include "hal/display/kms_display.h"
#include "tests/vm/vkms_screen.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr int kWidth = 1024;
constexpr int kHeight = 768;
constexpr std::array<const char*, 4> kViews = {"front", "left", "right", "top"};

std::vector<RigCamera> vivid_cameras() {
  std::vector<RigCamera> cameras;
  for (std::size_t c = 0; c < kViews.size(); ++c) {
    RigCamera camera;
    camera.view = kViews[c];
    camera.patience = 2s;
    camera.setup.device = "platform:vivid-00" + std::to_string(c);
    camera.setup.formats = {CameraFormat::kNv12};
    camera.setup.width = 1280;
    camera.setup.height = 720;
    camera.setup.rate = 60.0;
    cameras.push_back(camera);
  }
  return cameras;
}

Rig rig() {
  const std::string lines[] = {"frame.width=1024", "frame.height=768", "frame.center=[512, 384]",
                               "frame.radius=384"};
  return load_named_rig("domemaster-1k-4", lines);
}

// Presents as the screen does, then looks at it.
class CheckedDisplay final : public Display {
 public:
  CheckedDisplay(Display& display, const LiveFrames& live, WorkerPool& pool)
      : display_(display),
        live_(live),
        warp_(make_native_to_xrgb_warp(live.rig(), NativeLayout::kNv12, Cpu::kScalar, pool)),
        expected_(PixelFormat::kXrgb8888, {kWidth, kHeight}) {}
  DisplayBuffer back_buffer() noexcept override { return display_.back_buffer(); }
  Presented present(nanoseconds when) noexcept override {
    const Presented presented = display_.present(when);
    if (presented.result == Present::kShown) compare();
    return presented;
  }
  Presented repeat(nanoseconds when) noexcept override { return display_.repeat(when); }
  nanoseconds period() const noexcept override { return display_.period(); }
  const char* trouble() const noexcept override { return display_.trouble(); }

  int compared() const { return compared_; }
  long wrong() const { return wrong_; }
  long bright() const { return bright_; }

 private:
  void compare() {
    warp_->warp(live_.faces().faces(), expected_.pixels());
    const std::vector<std::uint32_t> screen = vkms_screen(kWidth, kHeight);
    ASSERT_EQ(screen.size(), static_cast<std::size_t>(kWidth) * kHeight);
    for (int y = 0; y < kHeight; ++y) {
      const auto* row = expected_.pixels().samples<std::uint32_t>(0, y);
      for (int x = 0; x < kWidth; ++x) {
        const std::uint32_t shown =
            screen[static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x)] & 0xffffffU;
        wrong_ += shown != (row[x] & 0xffffffU);
        bright_ += (shown & 0xffU) > 60U || (shown >> 8U & 0xffU) > 60U || (shown >> 16U) > 60U;
      }
    }
    ++compared_;
  }

  Display& display_;
  const LiveFrames& live_;
  std::unique_ptr<NativeWarp<MutableImage>> warp_;
  ImageBuffer expected_;
  int compared_ = 0;
  long wrong_ = 0;
  long bright_ = 0;
};

TEST(PicturePath, WhatTheCamerasSeeIsOnTheScreenToTheBit) {
  MonotonicClock clock;
  WorkerPool pool(1);
  CameraDrivers drivers;
  LiveFrames live(rig(), drivers.open(vivid_cameras(), clock, nullptr), SyncSettings{20ms, 2s}, best_cpu(),
                  pool, clock);
  KmsDisplay kms(clock, {"Virtual-1", *parse_kms_mode("1024x768"), {}, KmsMemoryKind::kDumb}, kWidth,
                 kHeight);
  CheckedDisplay display(kms, live, pool);
  FrameLoop loop(live, display, clock, pool);
  EXPECT_EQ(loop.run(5s), LoopEnd::kTimeUp);
  EXPECT_GE(display.compared(), 10);
  EXPECT_EQ(display.wrong(), 0) << "pixels";
  EXPECT_GT(display.bright(), display.compared() * 100'000L) << "vivid's colour bars";
  EXPECT_EQ(live.pixel_bytes_copied(), 0);
  std::uint64_t frames = 0;
  int cropped = 0;
  for (const OpenCamera& camera : live.cameras()) {
    EXPECT_GT(camera.watch->counts().frames, 5U) << camera.settings.view;
    frames += camera.watch->counts().frames;
    const CameraMode& mode = camera.watch->mode();
    std::printf("camera %s sends %d x %d from (%d, %d)\n", camera.settings.view.c_str(), mode.width,
                mode.height, mode.crop.x, mode.crop.y);
    cropped += mode.width * mode.height < 1280 * 720 ? 1 : 0;
  }
  EXPECT_GE(cropped, 2) << "not all of every face is looked at";
  std::printf("picture-path: %llu camera-frames\n", static_cast<unsigned long long>(frames));
  std::printf("picture-path: %d frames-compared\n", display.compared());
}

}  // namespace
}  // namespace cupola
