// The watch over lost lines, step by step on fake ones.
// SPDX-License-Identifier: MIT
#include "hal/gpio/gpio_watch.h"

#include <cerrno>

#include <gtest/gtest.h>

#include "hal/gpio/fake_gpio.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using Poll = GpioWatch::Poll;

class GpioWatchTest : public testing::Test {
 protected:
  static GpioLine line(const char* name, bool output, std::chrono::microseconds debounce = 0us) {
    GpioLine line;
    line.name = name;
    line.output = output;
    line.debounce = debounce;
    return line;
  }
  Poll poll() { return watch_.poll(edge_); }
  // Polls every millisecond until `time`; how often the watch said `what`.
  int count(Poll what, nanoseconds time) {
    int times = 0;
    while (clock_.now() < time) {
      clock_.advance(1ms);
      for (Poll said = poll(); said != Poll::kNothing; said = poll()) times += said == what ? 1 : 0;
    }
    return times;
  }

  FakeClock clock_;
  FakeGpio fake_{clock_, {{"panel", {"play", "lamp"}}}};
  GpioWatch watch_{fake_, {line("play", false, 5ms), line("lamp", true)}, clock_};
  GpioEdge edge_;
};

TEST_F(GpioWatchTest, TriesALostChipEveryTenthOfASecond) {
  EXPECT_EQ(poll(), Poll::kNothing);
  EXPECT_EQ(fake_.starts(), 1);
  fake_.unplug("panel", 1s);
  fake_.plug("panel", 2s + 30ms);
  EXPECT_EQ(count(Poll::kLost, 2s), 1);
  EXPECT_EQ(watch_.counts().losses, 1U);
  EXPECT_EQ(watch_.counts().failed_starts, 10U);
  EXPECT_EQ(watch_.trouble().cause, GpioCause::kMissing);
  EXPECT_LE(watch_.deadline(), clock_.now() + 100ms);
  EXPECT_EQ(count(Poll::kBack, 2s + 130ms), 1);
  EXPECT_EQ(watch_.counts().returns, 1U);
  EXPECT_EQ(watch_.state(), GpioState::kWorking);
}

TEST_F(GpioWatchTest, SaysOnceThatTheLinesWereNeverThere) {
  fake_.take("lamp", true);
  EXPECT_EQ(poll(), Poll::kLost);
  EXPECT_EQ(watch_.trouble().cause, GpioCause::kBusy);
  EXPECT_EQ(watch_.trouble().line, 1);
  EXPECT_EQ(count(Poll::kLost, 1s), 0);
  fake_.take("lamp", false);
  EXPECT_EQ(count(Poll::kBack, 2s), 1);
  EXPECT_EQ(watch_.counts().losses, 0U) << "what never worked was not lost";
  EXPECT_EQ(watch_.counts().returns, 0U);
}

TEST_F(GpioWatchTest, SurvivesAHundredUnplugs) {
  for (int i = 0; i < 100; ++i) {
    fake_.unplug("panel", i * 1s + 200ms);
    fake_.plug("panel", i * 1s + 500ms);
    fake_.bounce("play", i % 2 == 0, i * 1s + 700ms, 3, 1ms);
  }
  EXPECT_EQ(count(Poll::kEdge, 100s), 100);
  EXPECT_EQ(watch_.counts().losses, 100U);
  EXPECT_EQ(watch_.counts().returns, 100U);
}

TEST_F(GpioWatchTest, NoticesAPlugThatWasPulledAndPutBackBetweenTwoPolls) {
  EXPECT_EQ(poll(), Poll::kNothing);
  watch_.set(1, true);
  fake_.unplug("panel", 10ms);
  fake_.plug("panel", 11ms);
  clock_.advance(16ms);
  EXPECT_EQ(poll(), Poll::kLost);
  EXPECT_EQ(count(Poll::kBack, 200ms), 1);
  EXPECT_TRUE(fake_.high("lamp"));
}

TEST_F(GpioWatchTest, TakesTheLevelsOfAReturnWithoutMakingUpEdges) {
  EXPECT_EQ(poll(), Poll::kNothing);
  fake_.unplug("panel", 10ms);
  fake_.pull("play", true, 20ms);
  fake_.plug("panel", 30ms);
  EXPECT_EQ(count(Poll::kEdge, 1s), 0);
  EXPECT_TRUE(watch_.active(0));
}

TEST_F(GpioWatchTest, KeepsTheLastLevelWhileTheChipIsGone) {
  fake_.pull("play", true, 0ms);
  EXPECT_EQ(poll(), Poll::kNothing);
  EXPECT_TRUE(watch_.active(0)) << "the level at the start is no edge, but is known";
  fake_.unplug("panel", 10ms);
  EXPECT_EQ(count(Poll::kLost, 500ms), 1);
  EXPECT_TRUE(watch_.active(0));
}

TEST_F(GpioWatchTest, ForgetsAnUnsettledEdgeOfALostChip) {
  EXPECT_EQ(poll(), Poll::kNothing);
  fake_.pull("play", true, 10ms);
  fake_.unplug("panel", 12ms);
  fake_.pull("play", false, 20ms);
  fake_.plug("panel", 30ms);
  EXPECT_EQ(count(Poll::kEdge, 1s), 0);
  EXPECT_FALSE(watch_.active(0));
}

TEST_F(GpioWatchTest, TakesARefusedOutputForALossAndSetsItAgain) {
  EXPECT_EQ(poll(), Poll::kNothing);
  fake_.refuse(FakeGpioCall::kSet, EIO, 1);
  watch_.set(1, true);
  EXPECT_FALSE(fake_.high("lamp"));
  EXPECT_LE(watch_.deadline(), clock_.now());
  EXPECT_EQ(poll(), Poll::kLost);
  EXPECT_EQ(watch_.trouble().error, EIO);
  EXPECT_EQ(count(Poll::kBack, 200ms), 1);
  EXPECT_TRUE(fake_.high("lamp"));
  EXPECT_EQ(watch_.counts().losses, 1U);
}

TEST_F(GpioWatchTest, TakesARefusedPollForALoss) {
  EXPECT_EQ(poll(), Poll::kNothing);
  fake_.refuse(FakeGpioCall::kPoll, EIO, 1);
  EXPECT_EQ(count(Poll::kLost, 1s), 1);
  EXPECT_EQ(watch_.counts().returns, 1U);
}

TEST_F(GpioWatchTest, WritesAnOutputOnlyWhenItChanges) {
  EXPECT_EQ(poll(), Poll::kNothing);
  for (int i = 0; i < 10; ++i) watch_.set(1, i >= 5);
  ASSERT_EQ(fake_.writes().size(), 2U) << "at the start, and one change";
  EXPECT_EQ(fake_.writes()[1].line, "lamp");
  EXPECT_TRUE(fake_.writes()[1].high);
}

TEST_F(GpioWatchTest, HandsOnOnlyTheEdgesThatAreWanted) {
  for (const GpioEdges edges : {GpioEdges::kToActive, GpioEdges::kToInactive}) {
    FakeClock clock;
    FakeGpio fake(clock, {{"panel", {"play"}}});
    GpioLine button = line("play", false);
    button.edges = edges;
    GpioWatch watch(fake, {button}, clock);
    GpioEdge edge;
    watch.poll(edge);
    for (int i = 0; i < 6; ++i) fake.pull("play", i % 2 == 0, (i + 1) * 1ms);
    clock.advance(10ms);
    int seen = 0;
    for (; watch.poll(edge) == Poll::kEdge; ++seen) EXPECT_EQ(edge.active, edges == GpioEdges::kToActive);
    EXPECT_EQ(seen, 3);
    EXPECT_EQ(watch.counts().raw_edges, 6U);
  }
}

TEST_F(GpioWatchTest, WhoWaitsForItsDeadlineMissesNothing) {
  fake_.bounce("play", true, 30ms, 5, 1ms);
  EXPECT_EQ(poll(), Poll::kNothing);
  while (poll() != Poll::kEdge) {
    ASSERT_LT(clock_.now(), 1s);
    const std::array<int, 1> descriptors = {watch_.descriptor()};
    clock_.wait(descriptors, watch_.deadline());
  }
  EXPECT_EQ(clock_.now(), 39ms) << "5 ms after the last of five edges";
  EXPECT_EQ(edge_.at, 30ms);
}

}  // namespace
}  // namespace cupola
