// Stamps of either clock come out on CLOCK_MONOTONIC.
// SPDX-License-Identifier: MIT
#include "hal/time/boot_time.h"

#include <gtest/gtest.h>

#include "hal/time/clock.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;

TEST(BootTime, MovesAStampOfTheClockThatSleepsNotBackByTheSleep) {
  EXPECT_EQ(monotonic_stamp(3590s + 3600s, 3600s, 3600s), 3590s);
  EXPECT_EQ(monotonic_stamp(3600s + 3600s, 3600s, 3600s), 3600s);
}

TEST(BootTime, LeavesAMonotonicStampHoweverLongTheMachineSlept) {
  EXPECT_EQ(monotonic_stamp(3590s, 3600s, 3600s), 3590s);
  EXPECT_EQ(monotonic_stamp(3600s, 3600s, 7s), 3600s);
}

TEST(BootTime, LeavesEveryStampOfAMachineThatNeverSlept) {
  EXPECT_EQ(monotonic_stamp(3590s, 3600s, 0s), 3590s);
  EXPECT_EQ(monotonic_stamp(3601s, 3600s, 0s), 3601s);     // a device whose clock is ahead
  EXPECT_EQ(monotonic_stamp(3601s, 3600s, -80ns), 3601s);  // the clocks are read one after the other
}

TEST(BootTime, IsLateByLessThanTheEventsAgeAfterAShortSleep) {
  // Taken 40 ms ago by CLOCK_BOOTTIME; the machine slept for 15 ms.
  EXPECT_EQ(monotonic_stamp(3600s - 40ms + 15ms, 3600s, 15ms), 3600s - 25ms);
}

TEST(BootTime, OfThisMachineIsNotBehindItsMonotonicTime) {
  EXPECT_GE(time_asleep(), -1ms);
  const auto first = time_asleep();
  EXPECT_LT(time_asleep() - first, 1s);
}

}  // namespace
}  // namespace cupola
