// Debouncing, as a function of edges and times.
// SPDX-License-Identifier: MIT
#include "hal/gpio/debouncer.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

struct Edge {
  bool active;
  nanoseconds at;
};

// "+3 -40": to active at 3 ms, to inactive at 40 ms; asked every `step` until `end`.
std::string handed_out(GpioDebounce kind, const std::vector<Edge>& edges, nanoseconds step = 1ms,
                       nanoseconds end = 200ms) {
  Debouncer debouncer(5ms, kind);
  std::string said;
  const auto ask = [&](nanoseconds now) {
    while (const auto change = debouncer.change(now)) {
      said += (said.empty() ? "" : " ") + std::string(change->active ? "+" : "-") +
              std::to_string(change->at / 1ms);
      EXPECT_EQ(debouncer.active(), change->active);
    }
  };
  std::size_t next = 0;
  for (nanoseconds now = step; now <= end; now += step) {
    for (; next < edges.size() && edges[next].at <= now; ++next) {
      ask(edges[next].at);
      debouncer.edge(edges[next].active, edges[next].at);
      ask(edges[next].at);
    }
    ask(now);
  }
  EXPECT_EQ(debouncer.deadline(), nanoseconds::max());
  return said;
}

std::string settled(const std::vector<Edge>& edges, nanoseconds step = 1ms) {
  return handed_out(GpioDebounce::kSettled, edges, step);
}
std::string at_once(const std::vector<Edge>& edges, nanoseconds step = 1ms) {
  return handed_out(GpioDebounce::kAtOnce, edges, step);
}

const std::vector<Edge> kClean = {{true, 10ms}, {false, 60ms}};
const std::vector<Edge> kBouncing = {{true, 10ms}, {false, 11ms}, {true, 12ms}, {false, 16ms},
                                     {true, 18ms}, {false, 60ms}, {true, 61ms}, {false, 63ms}};
const std::vector<Edge> kSpike = {{true, 10ms}, {false, 12ms}};
const std::vector<Edge> kShort = {{true, 10ms}, {false, 17ms}};

TEST(Debouncer, HandsOnACleanPress) {
  EXPECT_EQ(settled(kClean), "+10 -60");
  EXPECT_EQ(at_once(kClean), "+10 -60");
}

TEST(Debouncer, HandsOnABouncingPressOnceWithTheTimeOfItsFirstEdge) {
  EXPECT_EQ(settled(kBouncing), "+10 -60");
  EXPECT_EQ(at_once(kBouncing), "+10 -60");
}

TEST(Debouncer, DoesNotCareHowOftenItIsAsked) {
  for (const nanoseconds step :
       {nanoseconds(100us), nanoseconds(3ms), nanoseconds(16ms), nanoseconds(100ms)}) {
    EXPECT_EQ(settled(kBouncing, step), "+10 -60") << step.count();
    EXPECT_EQ(at_once(kBouncing, step), "+10 -60") << step.count();
    EXPECT_EQ(settled(kShort, step), "+10 -17") << step.count();
    EXPECT_EQ(at_once(kShort, step), "+10 -17") << step.count();
  }
}

TEST(Debouncer, KeepsSpikesBackUnlessItIsToAnswerAtOnce) {
  EXPECT_EQ(settled(kSpike), "");
  EXPECT_EQ(at_once(kSpike), "+10 -12");
}

TEST(Debouncer, BearsTwoEdgesToTheSameLevel) {
  EXPECT_EQ(settled({{false, 10ms}, {true, 30ms}, {true, 32ms}, {false, 60ms}, {false, 61ms}}), "+30 -60");
  EXPECT_EQ(at_once({{false, 10ms}, {true, 12ms}, {true, 13ms}, {false, 60ms}, {false, 61ms}}), "+12 -60");
}

TEST(Debouncer, AnswersAtOnceBeforeTheLineIsQuiet) {
  Debouncer debouncer(5ms, GpioDebounce::kAtOnce);
  debouncer.edge(true, 10ms);
  EXPECT_TRUE(debouncer.change(10ms));
  EXPECT_TRUE(debouncer.active());
  Debouncer patient(5ms, GpioDebounce::kSettled);
  patient.edge(true, 10ms);
  EXPECT_FALSE(patient.change(14ms));
  EXPECT_EQ(patient.deadline(), 15ms);
  EXPECT_TRUE(patient.change(15ms));
  EXPECT_EQ(patient.deadline(), nanoseconds::max());
}

TEST(Debouncer, WithoutATimeHandsOnEverything) {
  for (const GpioDebounce kind : {GpioDebounce::kSettled, GpioDebounce::kAtOnce}) {
    Debouncer debouncer(0ms, kind);
    for (int i = 0; i < 5; ++i) {
      const nanoseconds at = i * 1us;
      debouncer.edge(i % 2 == 0, at);
      const auto change = debouncer.change(at);
      ASSERT_TRUE(change);
      EXPECT_EQ(change->at, at);
      EXPECT_FALSE(debouncer.change(at));
    }
  }
}

TEST(Debouncer, ForgetsWhatWasUnderWayWhenItIsReset) {
  Debouncer debouncer(5ms, GpioDebounce::kSettled);
  debouncer.edge(true, 10ms);
  debouncer.reset(true);
  EXPECT_TRUE(debouncer.active());
  EXPECT_FALSE(debouncer.change(1s));
  EXPECT_EQ(debouncer.deadline(), nanoseconds::max());
}

}  // namespace
}  // namespace cupola
