// What every set of GPIO lines promises: run on the fake ones, and in a virtual machine on the kernel's.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "hal/gpio/gpio.h"
#include "hal/gpio/gpio_watch.h"
#include "hal/time/clock.h"

namespace cupola {

// Two chips and the other end of their lines. Chip "panel": play, next, blackout, lamp, shutter, taken, which
// somebody else has; chip "stage": sensor, tally. All are low at first.
class GpioBench {
 public:
  virtual ~GpioBench() = default;
  virtual Clock& clock() = 0;
  virtual Gpio& gpio() = 0;
  // Returns when the driver has seen it.
  virtual void pull(const std::string& line, bool high) = 0;
  // Changes the pin so quickly that the driver may miss some of it; an even number of times.
  virtual void storm(const std::string& line, int edges) = 0;
  virtual bool high(const std::string& line) = 0;
  virtual void unplug() = 0;  // "panel"
  virtual void plug() = 0;
};

struct GpioBenchMaker {
  const char* name;
  std::unique_ptr<GpioBench> (*make)();
};
inline void PrintTo(const GpioBenchMaker& maker, std::ostream* out) {
  *out << maker.name;
}

// Says at the end how many edges have arrived.
class EdgeCount final : public testing::Environment {
 public:
  explicit EdgeCount(const char* name) : name_(name) {}
  void TearDown() override {
    if (seen() > 0) std::printf("%s: %d events\n", name_, seen());
  }
  static int& seen() {
    static int count = 0;
    return count;
  }

 private:
  const char* name_;
};

class GpioContract : public testing::TestWithParam<GpioBenchMaker> {
 protected:
  static GpioLine input(const char* name) {
    GpioLine line;
    line.name = name;
    return line;
  }
  static GpioLine output(const char* name, bool active = false) {
    GpioLine line = input(name);
    line.output = true;
    line.active = active;
    return line;
  }

  // The levels; reports a failure and gives none when the lines do not start.
  GpioLevels start(const std::vector<GpioLine>& lines) {
    const auto started = gpio_.start(lines);
    const auto* trouble = std::get_if<GpioTrouble>(&started);
    EXPECT_FALSE(trouble) << describe(*trouble, lines);
    return trouble ? GpioLevels() : std::get<GpioLevels>(started);
  }
  GpioTrouble refused(const std::vector<GpioLine>& lines) {
    const auto started = gpio_.start(lines);
    const auto* trouble = std::get_if<GpioTrouble>(&started);
    EXPECT_TRUE(trouble);
    EXPECT_EQ(gpio_.descriptor(), -1);
    return trouble ? *trouble : GpioTrouble();
  }

  // Until there is something to tell or `patience` is over.
  GpioPoll next(GpioEdge& edge, std::chrono::nanoseconds patience = std::chrono::seconds(5)) {
    const std::chrono::nanoseconds deadline = clock_.now() + patience;
    for (;;) {
      GpioTrouble trouble;
      const GpioPoll polled = gpio_.poll(edge, trouble);
      if (polled == GpioPoll::kEdge) ++EdgeCount::seen();
      if (polled == GpioPoll::kLost) {
        EXPECT_EQ(trouble.cause, GpioCause::kGone) << describe(trouble, {});
      }
      if (polled != GpioPoll::kNothing || clock_.now() >= deadline) return polled;
      const std::array<int, 1> descriptors = {gpio_.descriptor()};
      clock_.wait(descriptors, std::min(deadline, clock_.now() + std::chrono::milliseconds(20)));
    }
  }
  void expect_edge(std::size_t line, bool active) {
    GpioEdge edge;
    ASSERT_EQ(next(edge), GpioPoll::kEdge);
    EXPECT_EQ(edge.line, line);
    EXPECT_EQ(edge.active, active);
  }
  void expect_nothing() {
    GpioEdge edge;
    EXPECT_EQ(next(edge, std::chrono::milliseconds(20)), GpioPoll::kNothing);
  }

  GpioWatch::Poll next(GpioWatch& watch, GpioEdge& edge,
                       std::chrono::nanoseconds patience = std::chrono::seconds(5)) {
    const std::chrono::nanoseconds deadline = clock_.now() + patience;
    for (;;) {
      const GpioWatch::Poll polled = watch.poll(edge);
      if (polled == GpioWatch::Poll::kEdge) ++EdgeCount::seen();
      if (polled != GpioWatch::Poll::kNothing || clock_.now() >= deadline) return polled;
      const std::array<int, 1> descriptors = {watch.descriptor()};
      clock_.wait(descriptors, std::min(deadline, watch.deadline()));
    }
  }

  std::unique_ptr<GpioBench> bench_ = GetParam().make();
  Clock& clock_ = bench_->clock();
  Gpio& gpio_ = bench_->gpio();
};

using namespace std::chrono_literals;  // NOLINT: for tests

TEST_P(GpioContract, StartsWithTheLevelsOfItsInputs) {
  bench_->pull("next", true);
  std::vector<GpioLine> lines = {input("play"), input("next"), input("blackout"), output("lamp", true)};
  lines[2].active_low = true;
  const GpioLevels levels = start(lines);
  EXPECT_FALSE(levels[0]);
  EXPECT_TRUE(levels[1]);
  EXPECT_TRUE(levels[2]) << "low, and active when low";
  expect_nothing();
}

TEST_P(GpioContract, ReportsEveryEdgeOnceAndWhenItWas) {
  start({input("play"), input("next")});
  std::chrono::nanoseconds before = clock_.now();
  for (int i = 0; i < 40; ++i) {
    const std::size_t line = i / 2 % 2;
    bench_->pull(line == 0 ? "play" : "next", i % 2 == 0);
    GpioEdge edge;
    ASSERT_EQ(next(edge), GpioPoll::kEdge);
    EXPECT_EQ(edge.line, line);
    EXPECT_EQ(edge.active, i % 2 == 0);
    EXPECT_GE(edge.at, before);
    EXPECT_LE(edge.at, clock_.now());
    before = clock_.now();
  }
  expect_nothing();
}

TEST_P(GpioContract, KeepsEdgesUntilTheyArePolled) {
  start({input("play")});
  const std::chrono::nanoseconds begun = clock_.now();
  for (int i = 0; i < 6; ++i) bench_->pull("play", i % 2 == 0);
  const std::chrono::nanoseconds ended = clock_.now();
  std::chrono::nanoseconds before = begun;
  for (int i = 0; i < 6; ++i) {
    GpioEdge edge;
    ASSERT_EQ(next(edge), GpioPoll::kEdge);
    EXPECT_EQ(edge.active, i % 2 == 0);
    EXPECT_GT(edge.at, before);
    EXPECT_LE(edge.at, ended) << "when it was, not when it was asked for";
    before = edge.at;
  }
  expect_nothing();
}

TEST_P(GpioContract, EndsAStormOfEdgesOnTheRightLevel) {
  start({input("play"), input("next")});
  for (const bool last : {true, false}) {
    bench_->storm("play", 100);
    bench_->pull("play", last);
    GpioEdge edge;
    GpioEdge newest{0, !last, 0ns};
    int edges = 0;
    for (; next(edge, 20ms) == GpioPoll::kEdge; ++edges) newest = edge;
    EXPECT_GE(edges, 1);
    EXPECT_EQ(newest.active, last) << "after " << edges << " edges";
  }
}

TEST_P(GpioContract, EndsOnTheRightLevelWhenMoreEdgesCameThanAreKept) {
  start({input("play"), input("next")});
  for (int i = 0; i < 101; ++i) bench_->pull("play", i % 2 == 0);
  GpioEdge edge;
  int edges = 0;
  while (next(edge, 20ms) == GpioPoll::kEdge) ++edges;
  EXPECT_GE(edges, 16);
  EXPECT_LT(edges, 101);
  EXPECT_TRUE(edge.active) << "after " << edges << " edges";
}

TEST_P(GpioContract, SetsOutputs) {
  start({output("lamp", true), input("play"), output("shutter")});
  EXPECT_TRUE(bench_->high("lamp"));
  EXPECT_FALSE(bench_->high("shutter"));
  for (const bool active : {true, false, true}) {
    EXPECT_FALSE(gpio_.set(2, active));
    EXPECT_EQ(bench_->high("shutter"), active);
    EXPECT_TRUE(bench_->high("lamp"));
  }
}

TEST_P(GpioContract, TurnsActiveLowLinesRound) {
  std::vector<GpioLine> lines = {input("play"), output("lamp", true)};
  for (GpioLine& line : lines) line.active_low = true;
  EXPECT_TRUE(start(lines)[0]);
  EXPECT_FALSE(bench_->high("lamp"));
  EXPECT_FALSE(gpio_.set(1, false));
  EXPECT_TRUE(bench_->high("lamp"));
  bench_->pull("play", true);
  expect_edge(0, false);
  bench_->pull("play", false);
  expect_edge(0, true);
}

TEST_P(GpioContract, TakesEveryBiasThatTheDriverHas) {
  for (const GpioBias bias : {GpioBias::kNone, GpioBias::kPullDown, GpioBias::kPullUp, GpioBias::kAsIs}) {
    GpioLine line = input("play");
    line.bias = bias;
    start({line});
  }
}

TEST_P(GpioContract, WakesWhoWaitsForAnEdge) {
  start({input("play"), output("lamp")});
  const std::array<int, 1> descriptors = {gpio_.descriptor()};
  EXPECT_FALSE(clock_.wait(descriptors, clock_.now() + 5ms));
  bench_->pull("play", true);
  EXPECT_TRUE(clock_.wait(descriptors, clock_.now() + 1s));
  expect_edge(0, true);
  expect_nothing();
  EXPECT_FALSE(clock_.wait(descriptors, clock_.now() + 5ms)) << "it was polled";
}

TEST_P(GpioContract, WorksWithLinesOfSeveralChips) {
  start({input("play"), output("tally"), input("sensor"), output("lamp")});
  bench_->pull("sensor", true);
  expect_edge(2, true);
  bench_->pull("play", true);
  expect_edge(0, true);
  EXPECT_FALSE(gpio_.set(1, true));
  EXPECT_TRUE(bench_->high("tally"));
  EXPECT_FALSE(bench_->high("lamp"));
  EXPECT_FALSE(gpio_.set(3, true));
  EXPECT_TRUE(bench_->high("lamp"));
}

TEST_P(GpioContract, FindsLinesByTheirChip) {
  GpioLine by_offset;
  by_offset.chip = "panel";
  by_offset.offset = 1;  // next
  GpioLine by_both = input("sensor");
  by_both.chip = "stage";
  start({by_offset, by_both});
  bench_->pull("next", true);
  expect_edge(0, true);
  bench_->pull("sensor", true);
  expect_edge(1, true);
}

TEST_P(GpioContract, SaysWhichLineIsMissing) {
  GpioTrouble trouble = refused({input("play"), input("paly")});
  EXPECT_EQ(trouble.cause, GpioCause::kMissing);
  EXPECT_EQ(trouble.line, 1);

  GpioLine elsewhere = input("play");
  elsewhere.chip = "stage";
  EXPECT_EQ(refused({elsewhere}).cause, GpioCause::kMissing);
  elsewhere.chip = "no-such-chip";
  EXPECT_EQ(refused({elsewhere}).cause, GpioCause::kMissing);
  GpioLine beyond;
  beyond.chip = "panel";
  beyond.offset = 1000;
  EXPECT_EQ(refused({beyond}).cause, GpioCause::kMissing);
}

TEST_P(GpioContract, SaysWhichLineIsTaken) {
  const GpioTrouble trouble = refused({input("play"), output("lamp"), input("taken")});
  EXPECT_EQ(trouble.cause, GpioCause::kBusy);
  EXPECT_EQ(trouble.line, 2);
  EXPECT_EQ(refused({input("play"), input("play")}).cause, GpioCause::kBusy);
  start({input("play"), output("lamp")});  // which were not kept
}

TEST_P(GpioContract, GivesItsLinesBackWhenItStops) {
  start({input("play"), output("lamp")});
  gpio_.stop();
  EXPECT_EQ(gpio_.descriptor(), -1);
  GpioEdge edge;
  GpioTrouble trouble;
  EXPECT_EQ(gpio_.poll(edge, trouble), GpioPoll::kNothing);
  start({output("play"), input("lamp")});
  start({input("play"), output("lamp")});  // stops by itself
}

TEST_P(GpioContract, LosesAChipAndFindsItAgain) {
  const std::vector<GpioLine> lines = {input("play"), output("lamp")};
  for (int i = 0; i < 3; ++i) {
    start(lines);
    bench_->unplug();
    GpioEdge edge;
    EXPECT_EQ(next(edge), GpioPoll::kLost);
    EXPECT_EQ(next(edge), GpioPoll::kLost) << "until it is started again";
    const std::optional<GpioTrouble> trouble = gpio_.set(1, true);
    ASSERT_TRUE(trouble);
    EXPECT_EQ(trouble->cause, GpioCause::kGone);
    EXPECT_EQ(refused(lines).cause, GpioCause::kMissing);
    bench_->plug();
    start(lines);
    bench_->pull("play", true);
    expect_edge(0, true);
    bench_->pull("play", false);
    expect_edge(0, false);
    EXPECT_FALSE(gpio_.set(1, true));
    EXPECT_TRUE(bench_->high("lamp"));
    gpio_.stop();
  }
}

TEST_P(GpioContract, NoticesTheLossOfAChipWithOutputsAlone) {
  start({output("lamp"), output("tally"), input("sensor")});
  expect_nothing();
  bench_->unplug();
  GpioEdge edge;
  EXPECT_EQ(next(edge), GpioPoll::kLost);
  bench_->plug();
}

TEST_P(GpioContract, ChipsThatAreNotUsedMayGo) {
  start({input("sensor"), output("tally")});
  bench_->unplug();
  expect_nothing();
  bench_->pull("sensor", true);
  expect_edge(0, true);
  bench_->plug();
}

TEST_P(GpioContract, TheWatchHandsOnOneEdgeOfABouncingPress) {
  for (const GpioDebounce kind : {GpioDebounce::kSettled, GpioDebounce::kAtOnce}) {
    GpioLine button = input("play");
    button.debounce = 200ms;  // a busy machine may take a while from edge to edge
    button.debounce_kind = kind;
    GpioWatch watch(gpio_, {button, output("lamp")}, clock_);
    GpioEdge edge;
    ASSERT_EQ(next(watch, edge, 5ms), GpioWatch::Poll::kNothing);
    for (const bool active : {true, false}) {
      const std::chrono::nanoseconds begun = clock_.now();
      for (const bool level : {active, !active, active, !active, active}) bench_->pull("play", level);
      ASSERT_EQ(next(watch, edge), GpioWatch::Poll::kEdge);
      EXPECT_EQ(edge.active, active);
      EXPECT_EQ(watch.active(0), active);
      EXPECT_GE(edge.at, begun);
      EXPECT_LE(edge.at, begun + 150ms);
      EXPECT_EQ(next(watch, edge, 300ms), GpioWatch::Poll::kNothing);
    }
    EXPECT_EQ(watch.counts().edges, 2U);
    EXPECT_GE(watch.counts().raw_edges, 6U);
  }
}

TEST_P(GpioContract, TheWatchBringsBackALostChipWithItsOutputsAsTheyWereWanted) {
  GpioWatch watch(gpio_, {input("play"), output("lamp"), output("shutter"), input("sensor")}, clock_);
  GpioEdge edge;
  ASSERT_EQ(next(watch, edge, 5ms), GpioWatch::Poll::kNothing);
  watch.set(1, true);
  EXPECT_TRUE(bench_->high("lamp"));
  for (int i = 0; i < 3; ++i) {
    const bool shut = i % 2 == 0;
    bench_->unplug();
    ASSERT_EQ(next(watch, edge), GpioWatch::Poll::kLost);
    EXPECT_EQ(watch.state(), GpioState::kLost);
    watch.set(2, shut);
    EXPECT_EQ(next(watch, edge, 250ms), GpioWatch::Poll::kNothing);
    bench_->plug();
    const std::chrono::nanoseconds plugged = clock_.now();
    ASSERT_EQ(next(watch, edge), GpioWatch::Poll::kBack);
    EXPECT_LE(clock_.now(), plugged + 1s);
    EXPECT_TRUE(bench_->high("lamp"));
    EXPECT_EQ(bench_->high("shutter"), shut);
    bench_->pull("play", true);
    ASSERT_EQ(next(watch, edge), GpioWatch::Poll::kEdge);
    EXPECT_TRUE(edge.active);
    bench_->pull("play", false);
    ASSERT_EQ(next(watch, edge), GpioWatch::Poll::kEdge);
  }
  EXPECT_EQ(watch.counts().losses, 3U);
  EXPECT_EQ(watch.counts().returns, 3U);
}

}  // namespace cupola
