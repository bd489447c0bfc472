// The shipped loop around a show whose frames are timed.
// SPDX-License-Identifier: MIT
#include "firmware/bench_play.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "firmware/frame_loop.h"
#include "firmware/show_frames.h"
#include "hal/display/fake_display.h"

namespace cupola {
namespace {

using std::chrono::nanoseconds;

class TimedFrames final : public FrameMaker {
 public:
  TimedFrames(ShowFrames& frames, bool whole, Clock& clock)
      : frames_(frames), whole_(whole), clock_(clock), work_(std::size_t{1} << 20) {}
  Change advance(const Due& due) noexcept override {
    begun_ = clock_.now();
    const Change change = frames_.advance(due);
    done_ = clock_.now();
    return whole_ && change == Change::kUnchanged ? Change::kNew : change;
  }
  WarpWork warp(const MutableImage& frame, int age) noexcept override {
    const WarpWork work = frames_.warp(frame, whole_ ? 0 : age);
    done_ = clock_.now();
    return work;
  }
  void shown(nanoseconds flipped_at) noexcept override {
    work_.add(done_ - begun_);
    frames_.shown(flipped_at);
  }
  double rate() const override { return frames_.rate(); }
  void report(ShowReport& report) const noexcept override { frames_.report(report); }
  std::vector<double> work_ms() const { return work_.milliseconds(); }

 private:
  ShowFrames& frames_;
  bool whole_;
  Clock& clock_;
  nanoseconds begun_{0}, done_{0};
  TimeRing work_;
};

}  // namespace

PlayBench measure_play(const Show& show, nanoseconds time, bool whole, Cpu cpu, WorkerPool& pool,
                       TableCache* cache) {
  MonotonicClock clock;
  ShowFrames frames(show, Method::kEwa, cpu, pool, false, cache);
  TimedFrames timed(frames, whole, clock);
  const nanoseconds period(std::llround(1e9 / frames.rate()));
  FakeDisplay display(clock, show.rig.frame.size.width, show.rig.frame.size.height, period);
  for (const std::string& line : settle(show.machine, pool)) fmt::print(stderr, "cupola: {}\n", line);
  FrameLoop loop(timed, display, clock, pool);
  loop.run(time);
  return {loop.counts(), Percentiles(timed.work_ms()), 1e-6 * static_cast<double>(period.count())};
}

}  // namespace cupola
