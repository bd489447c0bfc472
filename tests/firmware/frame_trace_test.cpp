// The trace: JSON that a parser takes, of stages that lie within their frames.
// SPDX-License-Identifier: MIT
#include "firmware/frame_trace.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "firmware/frame_loop.h"
#include "hal/display/fake_display.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

// Takes 2 ms for the faces and 3 ms for the warp, every tenth time 40.
class SlowFrames final : public FrameMaker {
 public:
  explicit SlowFrames(FakeClock& clock) : clock_(clock) {}
  Change advance(const Due&) noexcept override {
    clock_.advance(2ms);
    return ++made_ % 3 == 0 ? Change::kUnchanged : Change::kNew;
  }
  WarpWork warp(const MutableImage&, int) noexcept override {
    clock_.advance(made_ % 10 == 1 ? 40ms : 3ms);
    return {};
  }
  void shown(nanoseconds) noexcept override {}
  double rate() const override { return 60.0; }
  void report(ShowReport& report) const noexcept override {
    report.cue = static_cast<std::size_t>(made_ / 1000);
    report.queue = {made_ / 50 % 8, 8};
  }

 private:
  FakeClock& clock_;
  int made_ = 0;
};

TEST(FrameTrace, HasEveryFrameOfTheLastMinuteAndItsStagesWithin) {
  FakeClock clock;
  SlowFrames frames(clock);
  FakeDisplay display(clock, 8, 8, 16'666'667ns);
  WorkerPool pool(1);
  ControlLink link;
  FrameLoop loop(frames, display, clock, pool, nullptr, &link);
  loop.run(90s);
  const nlohmann::json trace = nlohmann::json::parse(link.trace.json());
  struct Frame {
    double begin = 0.0, end = 0.0, parts = 0.0;
  };
  std::map<std::int64_t, Frame> all;
  double first = 1e300;
  double last = 0.0;
  std::int64_t late = 0;
  std::int64_t dropped = 0;
  std::vector<std::int64_t> cues;
  std::vector<std::int64_t> levels;
  for (const nlohmann::json& event : trace.at("traceEvents")) {
    if (event.at("ph") == "M") continue;
    const double begin = event.at("ts");
    first = std::min(first, begin);
    last = std::max(last, begin);
    if (event.at("ph") == "C") {
      EXPECT_EQ(event.at("name"), "decoded ahead");
      levels.push_back(event.at("args").at("frames"));
      continue;
    }
    if (event.at("name") == "cue") {
      EXPECT_EQ(event.at("ph"), "i");
      cues.push_back(event.at("args").at("cue"));
      continue;
    }
    if (event.at("ph") == "i") {
      (event.at("name") == "late" ? late : dropped) += event.at("args").at("frames").get<std::int64_t>();
      continue;
    }
    ASSERT_EQ(event.at("ph"), "X");
    Frame& frame = all[event.at("args").at("frame")];
    const double took = event.at("dur");
    if (event.at("name") == "frame") {
      frame.begin = begin;
      frame.end = begin + took;
    } else {
      ASSERT_GE(begin, frame.begin - 0.01);
      ASSERT_LE(begin + took, frame.end + 0.01);
      frame.parts += took;
    }
  }
  EXPECT_NEAR(last - first, 60e6, 1e5);
  EXPECT_GT(all.size(), 2000U);
  for (const auto& [number, frame] : all) EXPECT_NEAR(frame.parts, frame.end - frame.begin, 0.05) << number;
  EXPECT_EQ(cues.back(), cues.front() + static_cast<std::int64_t>(cues.size()) - 1);
  EXPECT_GE(cues.size(), 3U);
  ASSERT_GT(levels.size(), 40U);
  for (std::size_t i = 1; i < levels.size(); ++i)
    EXPECT_EQ(levels[i], (levels[i - 1] + 1) % 8) << "once a change";
  EXPECT_GT(late, 0);
  EXPECT_NEAR(static_cast<double>(dropped), static_cast<double>(loop.counts().frames_dropped) * 60.0 / 90.0,
              10.0);
}

TEST(FrameTrace, IsWholeWhileItIsWritten) {
  FrameTrace trace;
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::int64_t i = 1; !done; ++i) {
      trace.add(TraceWhat::kFrame, nanoseconds(i * 1000), nanoseconds(i * 1000 + i % 1000), i);
    }
  });
  std::int64_t newest = 0;
  for (int read = 0; read < 4 || newest < 200'000; ++read) {
    const nlohmann::json json = nlohmann::json::parse(trace.json());
    std::int64_t before = 0;
    for (const nlohmann::json& event : json.at("traceEvents")) {
      if (event.at("ph") == "M") continue;
      const std::int64_t number = event.at("args").at("frame");
      ASSERT_GT(number, before);
      before = number;
      ASSERT_EQ(event.at("ts").get<double>(), static_cast<double>(number));
      ASSERT_NEAR(event.at("dur").get<double>(), 1e-3 * static_cast<double>(number % 1000), 1e-9);
    }
    newest = before;
  }
  done = true;
  writer.join();
}

}  // namespace
}  // namespace cupola
