// Cameras that drift, measured as shows measure them: they come to capture at once, and stay.
// SPDX-License-Identifier: MIT
#include "pipeline/source/frame_alignment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr nanoseconds kPeriod = 16'666'667ns;

// Frame by frame: when each camera captures, as nanoseconds; frame times in whole microseconds.
struct Cameras {
  struct Camera {
    double at = 0.0;
    double drift = 0.0;  // its clock's, as a share
    double frame = static_cast<double>(kPeriod.count());
  };
  explicit Cameras(std::vector<Camera> list) : cameras(std::move(list)), alignment(cameras.size(), kPeriod) {}

  void step() {
    std::vector<CameraFrame> frames(cameras.size());
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      Camera& camera = cameras[c];
      camera.at += camera.frame * (1.0 + camera.drift);
      // Half a millisecond of jitter.
      const auto hash = static_cast<std::uint32_t>((++count + c) * 2654435761U);
      const double jitter = 5e5 * (static_cast<double>(hash >> 8) / 16777216.0 - 0.5);
      frames[c].sequence = static_cast<std::uint64_t>(count);
      frames[c].captured_at = nanoseconds(std::llround(camera.at + jitter));
    }
    const nanoseconds now(std::llround(cameras[0].at + 12e6));
    for (std::size_t c = 0; c < cameras.size(); ++c) sync.offer(c, frames[c], now);
    sync.choose(now);
    while (sync.spent()) {
    }
    for (std::size_t c = 1; c < cameras.size(); ++c) {
      if (const auto frame = alignment.look(c, sync.offset(c), now)) {
        cameras[c].frame = 1e3 * std::round(1e-3 * static_cast<double>(frame->count()));
        ++changes;
      }
    }
  }
  double apart_ms(std::size_t c) const { return 1e-6 * (cameras[c].at - cameras[0].at); }

  std::vector<Camera> cameras;
  RigSync sync{4, {.tolerance = 8333us}};
  FrameAlignment alignment;
  int count = 0;
  int changes = 0;
};

TEST(FrameAlignment, BringsDriftingCamerasTogetherAndKeepsThem) {
  Cameras rig({{0.0, 0.0}, {7e6, 150e-6}, {-7e6, -200e-6}, {3e6, 20e-6}});
  for (int i = 0; i < 60 * 60; ++i) rig.step();
  double worst = 0.0;
  for (int i = 0; i < 10 * 60 * 60; ++i) {
    rig.step();
    for (std::size_t c = 1; c < 4; ++c) worst = std::max(worst, std::abs(rig.apart_ms(c)));
  }
  EXPECT_LT(worst, 0.4) << "milliseconds, ten minutes long";
}

TEST(FrameAlignment, DoesNotRunPastTheFirstCamera) {
  Cameras rig({{0.0, 0.0}, {6e6, 0.0}, {0.0, 0.0}, {0.0, 0.0}});
  double least = 10.0;
  for (int i = 0; i < 120 * 60; ++i) {
    rig.step();
    least = std::min(least, rig.apart_ms(1));
  }
  EXPECT_GT(least, -1.0);
  EXPECT_LT(std::abs(rig.apart_ms(1)), 0.4);
}

TEST(FrameAlignment, ChangesNothingOfCamerasThatAreTriggered) {
  FrameAlignment alignment(2, kPeriod);
  for (int i = 0; i < 600; ++i) EXPECT_FALSE(alignment.look(1, {20us, 2.0}, i * 100ms));
}

TEST(FrameAlignment, StaysWithinHalfAPerCentOfThePeriod) {
  FrameAlignment alignment(2, kPeriod);
  std::optional<nanoseconds> last;
  for (int i = 0; i < 600; ++i) {
    if (const auto frame = alignment.look(1, {8ms, 0.0}, i * 500ms)) last = frame;
  }
  ASSERT_TRUE(last) << "of a camera that does not obey";
  EXPECT_EQ(*last, nanoseconds(std::llround(0.995 * static_cast<double>(kPeriod.count()))));
}

}  // namespace
}  // namespace cupola
