// Clocks: the same promises from the machine's and from the fake one.
// SPDX-License-Identifier: MIT
#include "hal/time/clock.h"

#include <array>
#include <ctime>
#include <memory>

#include <gtest/gtest.h>
#include <unistd.h>

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

class Pipe {
 public:
  Pipe() { EXPECT_EQ(pipe(ends_.data()), 0); }
  ~Pipe() {
    close(ends_[0]);
    close(ends_[1]);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  int reads() const { return ends_[0]; }
  void fill() const { EXPECT_EQ(write(ends_[1], "x", 1), 1); }

 private:
  std::array<int, 2> ends_{};
};

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

TEST_P(ClockContract, WaitsUntilTheDeadlineWhenNothingComes) {
  const Pipe pipe;
  const std::array<int, 2> descriptors = {pipe.reads(), -1};
  const std::chrono::nanoseconds deadline = clock_->now() + 3ms;
  EXPECT_FALSE(clock_->wait(descriptors, deadline));
  EXPECT_GE(clock_->now(), deadline);
  EXPECT_FALSE(clock_->wait({}, deadline)) << "past: at once";
}

TEST_P(ClockContract, WakesForADescriptorWithSomethingToRead) {
  const Pipe pipe;
  pipe.fill();
  const std::array<int, 2> descriptors = {-1, pipe.reads()};
  const std::chrono::nanoseconds before = clock_->now();
  EXPECT_TRUE(clock_->wait(descriptors, before + 1h));
  EXPECT_TRUE(clock_->wait(descriptors, before - 1h)) << "asks, late as it is";
  EXPECT_LT(clock_->now(), before + 2s);
}

TEST_P(ClockContract, WakesForItsAlarms) {
  const int front = clock_->add_alarm();
  const int left = clock_->add_alarm();
  const std::array<int, 2> both = {front, left};
  const std::chrono::nanoseconds begin = clock_->now();
  EXPECT_FALSE(clock_->wait(both, begin)) << "not in sight at first";
  clock_->set_alarm(front, begin + 1h);
  clock_->set_alarm(left, begin + 3ms);
  EXPECT_TRUE(clock_->wait(both, begin + 30min));
  EXPECT_GE(clock_->now(), begin + 3ms);
  EXPECT_LT(clock_->now(), begin + 2s);
  EXPECT_TRUE(clock_->wait(both, begin)) << "goes on ringing until it is set again";
  clock_->set_alarm(left, std::chrono::nanoseconds::max());
  EXPECT_FALSE(clock_->wait(both, begin));
  clock_->set_alarm(front, std::chrono::nanoseconds(-5));
  EXPECT_TRUE(clock_->wait(both, begin)) << "at once when its time is past";
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

TEST(FakeClock, GoesToTheFirstAlarmThatIsWaitedFor) {
  FakeClock clock;
  const int front = clock.add_alarm();
  const int left = clock.add_alarm();
  const int nobodys = clock.add_alarm();
  clock.set_alarm(front, 20ms);
  clock.set_alarm(left, 10ms);
  clock.set_alarm(nobodys, 1ms);
  const std::array<int, 2> both = {front, left};
  EXPECT_TRUE(clock.wait(both, 50ms));
  EXPECT_EQ(clock.now(), 10ms);
  clock.set_alarm(left, std::chrono::nanoseconds::max());
  EXPECT_FALSE(clock.wait(both, 15ms));
  EXPECT_EQ(clock.now(), 15ms);
  EXPECT_TRUE(clock.wait(both, 20ms)) << "an alarm at the deadline rings";
  EXPECT_TRUE(clock.wait(both, 0ms)) << "and goes on ringing until it is set again";
  EXPECT_EQ(clock.now(), 20ms);
}

}  // namespace
}  // namespace cupola
