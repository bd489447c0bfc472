// Clocks: the same promises from the machine's and from the fake one.
// SPDX-License-Identifier: MIT
#include "hal/time/clock.h"

#include <ctime>
#include <memory>

#include <gtest/gtest.h>

namespace cupola {
namespace {

using namespace std::chrono_literals;

struct ClockMaker {
  const char* name;
  std::unique_ptr<Clock> (*make)();
};
void PrintTo(const ClockMaker& maker, std::ostream* out) {
  *out << maker.name;
}

class ClockContract : public testing::TestWithParam<ClockMaker> {
 protected:
  std::unique_ptr<Clock> clock_ = GetParam().make();
};

TEST_P(ClockContract, NeverRunsBackwards) {
  std::chrono::nanoseconds before = clock_->now();
  for (int i = 0; i < 10'000; ++i) {
    const std::chrono::nanoseconds now = clock_->now();
    ASSERT_GE(now, before);
    before = now;
  }
}

TEST_P(ClockContract, SleepsUntilTheDeadline) {
  const std::chrono::nanoseconds deadline = clock_->now() + 3ms;
  clock_->sleep_until(deadline);
  EXPECT_GE(clock_->now(), deadline);
  EXPECT_LT(clock_->now(), deadline + 2s);
}

TEST_P(ClockContract, DoesNotSleepForADeadlineInThePast) {
  const std::chrono::nanoseconds before = clock_->now();
  for (const std::chrono::nanoseconds deadline : {before, before - 1h, 0ns, std::chrono::nanoseconds(-5h)}) {
    clock_->sleep_until(deadline);
  }
  EXPECT_LT(clock_->now(), before + 2s);
}

INSTANTIATE_TEST_SUITE_P(
    All, ClockContract,
    testing::Values(ClockMaker{"Monotonic",
                               [] { return std::unique_ptr<Clock>(std::make_unique<MonotonicClock>()); }},
                    ClockMaker{"Fake", [] { return std::unique_ptr<Clock>(std::make_unique<FakeClock>()); }}),
    [](const auto& maker) { return std::string(maker.param.name); });

TEST(MonotonicClock, ReadsTheClockThatDriversStampFramesWith) {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  const auto direct = std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
  const auto now = MonotonicClock().now();
  EXPECT_GE(now, direct);
  EXPECT_LT(now, direct + 2s);
}

TEST(FakeClock, MovesOnlyWhenTold) {
  FakeClock clock;
  EXPECT_EQ(clock.now(), 0ns);
  clock.advance(5ms);
  EXPECT_EQ(clock.now(), 5ms);
  clock.sleep_until(7ms);
  EXPECT_EQ(clock.now(), 7ms);
  clock.sleep_until(1ms);
  EXPECT_EQ(clock.now(), 7ms);
}

}  // namespace
}  // namespace cupola
