// The bench of shows measures a show that runs.
// SPDX-License-Identifier: MIT
#include "firmware/bench_play.h"

#include <gtest/gtest.h>

namespace cupola {
namespace {

using namespace std::chrono_literals;

TEST(BenchPlay, TimesTheWorkOfEveryFrameShown) {
  const std::string lines[] = {"rig.frame.width=64", "rig.frame.height=48", "rig.frame.center=[32, 24]",
                               "rig.frame.radius=30", "cue.0.face_size=[32, 32]"};
  WorkerPool pool(2);
  const Show show = load_show("demo", lines);
  for (const bool whole : {false, true}) {
    const PlayBench bench = measure_play(show, 500ms, whole, Cpu::kScalar, pool, nullptr);
    EXPECT_GT(bench.counts.frames_presented, 5);  // 30 where the machine has the time
    EXPECT_EQ(bench.work_ms.count(), static_cast<std::size_t>(bench.counts.frames_presented));
    EXPECT_GT(bench.work_ms.at(0.0), 0.0);
    EXPECT_NEAR(bench.period_ms, 1000.0 / 60.0, 1e-4);
    EXPECT_EQ(bench.counts.heap_allocations, 0);
    if (whole) {
      EXPECT_EQ(bench.counts.frames_unchanged, 0);
      EXPECT_EQ(bench.counts.tiles.skipped, 0);
    }
  }
}

}  // namespace
}  // namespace cupola
