// The whole way of a picture in a virtual machine: the live show that is shipped, vivid's cameras, the warp,
// vkms' screen, read back and compared with the same buffers warped by the scalar kernels.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <string>

#include "firmware/frame_loop.h"
#include "firmware/live_frames.h"
#include "firmware/open_cameras.h"
#include "firmware/show.h"
#include "hal/display/kms_display.h"
#include "tests/vm/checked_display.h"
#include "tests/vm/vivid_controls.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr int kWidth = 1024;  // a mode that vkms has
constexpr int kHeight = 768;
constexpr std::size_t kCameras = 4;

Show live_show(const std::string& format) {
  const std::string lines[] = {"rig.frame.width=1024", "rig.frame.height=768", "rig.frame.center=[512, 384]",
                               "rig.frame.radius=384", "rig.display.format=\"" + format + "\""};
  return load_show("live", lines, "four-vivid-cameras");
}

class PicturePath : public testing::Test {
 protected:
  explicit PicturePath(const std::string& format = "XRGB8888") : show_(live_show(format)) {}
  // `flipped` after each flip, with how many there were before.
  void play(nanoseconds time, int compare_every, std::function<void(int)> flipped = {}) {
    display_.emplace(kms_, live_, pool_, compare_every, std::move(flipped));
    EXPECT_EQ(FrameLoop(live_, *display_, clock_, pool_).run(time), LoopEnd::kTimeUp);
    EXPECT_EQ(display_->wrong(), 0) << "pixels";
    EXPECT_GT(display_->bright(), display_->compared() * 100'000L) << "vivid's colour bars";
    std::uint64_t frames = 0;
    for (const OpenCamera& camera : live_.cameras()) frames += camera.watch->counts().frames;
    std::printf("picture-path: %llu camera-frames\n", static_cast<unsigned long long>(frames));
    std::printf("picture-path: %d frames-compared\n", display_->compared());
  }
  const CameraCounts& counts(std::size_t c) const { return live_.cameras()[c].watch->counts(); }
  SyncedFace::State state(std::size_t view) const { return live_.faces().sync().faces()[view].state; }

  MonotonicClock clock_;
  WorkerPool pool_{1};
  CameraDrivers drivers_;
  Show show_;
  LiveFrames live_{
      show_.rig, drivers_.open(show_.devices.cameras, clock_, nullptr), show_.devices.live, best_cpu(), pool_,
      clock_};
  KmsDisplay kms_{
      clock_, {"Virtual-1", *parse_kms_mode("1024x768"), {}, KmsMemoryKind::kDumb}, kWidth, kHeight};
  std::optional<CheckedDisplay> display_;
};

TEST_F(PicturePath, WhatTheCamerasSeeIsOnTheScreenToTheBit) {
  play(5s, 1);
  EXPECT_GE(display_->compared(), 10);
  EXPECT_EQ(live_.pixel_bytes_copied(), 0);
  int cropped = 0;
  for (const OpenCamera& camera : live_.cameras()) {
    EXPECT_GT(camera.watch->counts().frames, 5U) << camera.settings.view;
    const CameraMode& mode = camera.watch->mode();
    std::printf("camera %s sends %d x %d from (%d, %d)\n", camera.settings.view.c_str(), mode.width,
                mode.height, mode.crop.x, mode.crop.y);
    cropped += mode.width * mode.height < 1280 * 720 ? 1 : 0;
  }
  EXPECT_GE(cropped, 2) << "not all of every face is looked at";
}

class PicturePathInNv12 : public PicturePath {
 protected:
  PicturePathInNv12() : PicturePath("NV12") {}
};

TEST_F(PicturePathInNv12, TheScreenConvertsWhatTheWarpLeavesAsItIs) {
  play(5s, 1);
  EXPECT_GE(display_->compared(), 10);
  EXPECT_EQ(display_->in_nv12(), display_->compared());
  EXPECT_EQ(live_.pixel_bytes_copied(), 0);
}

// What the driver can do to a camera while it streams, one thing after the other, each on another camera.
TEST_F(PicturePath, TheShowGoesOnWhateverTheDriverDoes) {
  struct Deed {
    nanoseconds at;
    int camera;
    const char* control;
    double value;
  };
  const std::array<Deed, 7> deeds = {
      {{1s, 0, "percentage_of_dropped_buffers", 50},
       {3s, 0, "percentage_of_dropped_buffers", 0},
       {4s, 1, "disconnect", 1},
       {6s, 2, "inject_v4l2_buf_flag_error", 1},
       {7s, 3, "dv_timings_signal_mode", 1},  // none, for longer than the patience
       {9s, 3, "dv_timings_signal_mode", 0},
       {10s, 0, "inject_fatal_streaming_error", 1}}};
  const nanoseconds begun = clock_.now();
  std::size_t done = 0;
  std::array<int, kCameras> slates{};
  int slates_together = 0;
  play(13s, 8, [&](int) {
    int now = 0;
    for (std::size_t v = 0; v < kCameras; ++v) {
      const bool slate = state(v) == SyncedFace::State::kSlate;
      slates[v] += slate ? 1 : 0;
      now += slate ? 1 : 0;
    }
    slates_together = std::max(slates_together, now);
    for (; done < deeds.size() && clock_.now() - begun >= deeds[done].at; ++done)
      set_vivid(deeds[done].camera, deeds[done].control, deeds[done].value);
  });
  EXPECT_EQ(done, deeds.size());
  EXPECT_GE(display_->compared(), 10);
  EXPECT_GT(counts(0).dropped, 5U) << "half of two seconds'";
  EXPECT_EQ(counts(0).losses, 1U);
  EXPECT_EQ(counts(1).losses, 1U);
  EXPECT_EQ(counts(2).losses, 0U);
  EXPECT_EQ(counts(2).damaged, 1U);
  EXPECT_GE(counts(3).losses, 1U);
  EXPECT_GT(slates[3], 5) << "its slate stands while it has no signal";
  EXPECT_EQ(slates_together, 1) << "and nobody else's";
  for (std::size_t v = 0; v < kCameras; ++v) {
    EXPECT_NE(state(v), SyncedFace::State::kSlate) << v;
    EXPECT_GT(counts(v).frames, 50U) << v;
  }
}

}  // namespace
}  // namespace cupola
