// A live show whose ends are memory.
// SPDX-License-Identifier: MIT
#include "firmware/bench_live.h"

#include "firmware/live_frames.h"
#include "hal/display/fake_display.h"

namespace cupola {

using namespace std::chrono_literals;

LiveBench measure_live(const Rig& rig, PacedCameraDevice camera, std::chrono::nanoseconds time, Cpu cpu,
                       WorkerPool& pool) {
  MonotonicClock clock;
  std::vector<OpenCamera> cameras;
  for (const View& view : rig.views) {
    RigCamera settings;
    settings.view = view.name;
    settings.patience = 500ms;
    settings.setup.formats = {camera.format};
    settings.setup.width = camera.width;
    settings.setup.height = camera.height;
    cameras.emplace_back(std::move(settings), std::make_unique<PacedCamera>(clock, camera), clock);
    ++camera.number;
  }
  LiveFrames live(rig, std::move(cameras), LiveSettings{}, cpu, pool, clock);
  FakeDisplay display(clock, rig.frame.size.width, rig.frame.size.height);
  FrameLoop loop(live, display, clock, pool);
  loop.run(time);

  LiveBench bench;
  bench.counts = loop.counts();
  bench.latency_ms = Percentiles(live.latencies_ms());
  bench.warp_ms = Percentiles(loop.warp_ms());
  bench.period_ms = 1e-6 * static_cast<double>(display.period().count());
  bench.sets = static_cast<std::int64_t>(live.faces().sync().counts().sets);
  bench.whole_sets = static_cast<std::int64_t>(live.faces().sync().counts().whole);
  bench.bytes_copied = bench.counts.pixel_bytes_copied + live.pixel_bytes_copied();
  for (const OpenCamera& open : live.cameras()) {
    bench.frames_dropped += static_cast<std::int64_t>(open.watch->counts().dropped);
  }
  return bench;
}

}  // namespace cupola
