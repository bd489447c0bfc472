// The bench of live shows measures a show that runs: sets in step, nothing copied, nothing allocated.
// SPDX-License-Identifier: MIT
#include "firmware/bench_live.h"

#include <gtest/gtest.h>

#include "firmware/show.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;

TEST(BenchLive, PlaysInRealTimeFromCamerasInStep) {
  const std::string lines[] = {"frame.width=64", "frame.height=48", "frame.center=[32, 24]",
                               "frame.radius=30"};
  const Rig rig = load_named_rig("omnimax", lines);
  PacedCameraDevice camera;
  camera.width = 64;
  camera.height = 48;
  camera.jitter = 1ms;
  camera.latency = 4ms;
  WorkerPool pool(1);
  const LiveBench bench = measure_live(rig, camera, 1s, Cpu::kScalar, pool);
  EXPECT_GT(bench.counts.frames_presented, 10);  // 60 where the machine has the time
  EXPECT_GT(bench.sets, 10);
  EXPECT_LE(bench.whole_sets, bench.sets);
  EXPECT_GT(2 * bench.whole_sets, bench.sets)
      << "they are triggered at the same times; only where the machine paused is a set torn";
  EXPECT_EQ(bench.bytes_copied, 0);
  EXPECT_EQ(bench.counts.heap_allocations, 0);
  EXPECT_EQ(bench.latency_ms.count(), static_cast<std::size_t>(bench.sets));
  EXPECT_GE(bench.latency_ms.at(0.0), 4.0) << "no sooner than the cameras deliver";
  EXPECT_LE(bench.latency_ms.at(0.5), bench.latency_ms.at(0.999));
}

TEST(Percentiles, AreOfSortedValues) {
  EXPECT_EQ(Percentiles({}).at(0.5), 0.0);
  const Percentiles five({3, 1, 5, 2, 4});
  EXPECT_EQ(five.at(0.0), 1.0);
  EXPECT_EQ(five.at(0.5), 3.0);
  EXPECT_EQ(five.at(1.0), 5.0);
}

}  // namespace
}  // namespace cupola
