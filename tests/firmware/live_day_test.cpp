// A day of a live show with a day's troubles: the frame loop that is shipped, on fake devices.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "tests/firmware/live_show.h"
#include "tests/hal/sanitized.h"

namespace cupola {
namespace {

using namespace test;

constexpr int kHours = test::kSanitized ? 2 : 24;
constexpr int kLost = std::min(kHours, 6);  // every camera, in as many hours once

// Four cameras whose clocks run apart, that drop a frame in a hundred, and now and then something worse, each
// at another time.
void trouble(std::size_t number, FakeCameraDevice& device, CameraSetup&) {
  const auto c = static_cast<int>(number);
  device.drift_ppm = 30.0 * c;
  device.jitter = 1ms;
  device.faults = {{CameraFault::kDropped, 0ns, nanoseconds::max(), 1}};
  constexpr std::array<CameraFault, 3> kLosses = {CameraFault::kUnplugged, CameraFault::kSilent,
                                                  CameraFault::kNoSignal};
  for (int hour = 0; hour < kLost; ++hour) {
    const nanoseconds at = hour * kHours / kLost * 1h + (10 + 10 * c) * 1min;
    device.faults.push_back({kLosses[static_cast<std::size_t>(hour) % kLosses.size()], at, at + 10s});
  }
  device.faults.push_back({CameraFault::kDamaged, 1h + 5min, 1h + 6min, 50});
  device.faults.push_back({CameraFault::kShort, 1h + 7min, 1h + 7min + 1s});
}

TEST(LiveDay, PassesWithoutALateFrame) {
  const std::string tiny[] = {"frame.width=16", "frame.height=12", "frame.center=[8, 6]", "frame.radius=8"};
  LiveShow show(trouble, load_named_rig("omnimax", tiny));
  std::int64_t flips = 0;
  const LoopCounts counts = show.play(kHours * 1h, [&](int, DisplayBuffer) { ++flips; });
  EXPECT_NEAR(static_cast<double>(counts.frames_presented), kHours * 3600.0 * 60.0, 1.0);
  EXPECT_EQ(flips, counts.frames_presented);
  EXPECT_EQ(counts.frames_late, 0);
  EXPECT_EQ(counts.frames_dropped, 0);
  EXPECT_EQ(counts.frames_failed, 0);
  std::uint64_t frames = 0;
  std::uint64_t losses = 0;
  std::uint64_t starts = 0;
  for (std::size_t c = 0; c < 4; ++c) {
    const CameraCounts& camera = show.frames->cameras()[c].watch->counts();
    EXPECT_EQ(camera.losses, static_cast<std::uint64_t>(kLost) + 1) << "and a second of cut frames: silence";
    EXPECT_GT(camera.damaged, 1000U) << c;
    // A hundredth is dropped, and what would have come in ten seconds of each loss.
    const double seconds = 3600.0 * kHours - 10.0 * kLost;
    EXPECT_NEAR(static_cast<double>(camera.frames), 0.99 * 60.0 * seconds, 0.005 * 60.0 * seconds) << c;
    EXPECT_NE(show.frames->faces().sync().faces()[c].state, SyncedFace::State::kSlate) << c;
    frames += camera.frames;
    losses += camera.losses;
    starts += camera.starts;
  }
  // Only what was shown of a camera when it was lost; and only starts allocate.
  EXPECT_EQ(show.frames->pixel_bytes_copied(),
            static_cast<std::int64_t>(losses) * kFace.width * kFace.height * 3 / 2);
  EXPECT_LE(counts.heap_allocations, static_cast<std::int64_t>(starts) * 32);
  std::printf("a day of %d hours: %llu camera frames, %lld sets\n", kHours,
              static_cast<unsigned long long>(frames),
              static_cast<long long>(show.frames->faces().sync().counts().sets));
}

}  // namespace
}  // namespace cupola
