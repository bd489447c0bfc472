// OSC's times on the clock, and what waits for them.
// SPDX-License-Identifier: MIT
#include "firmware/osc_time.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <random>

#include "firmware/due_queue.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr OscTime kSecond = OscTime{1} << 32U;
constexpr WallTime k1970{};
constexpr WallTime kRound{2'085'978'496s};  // 2036-02-07 06:28:16, when NTP's count begins anew

TEST(OscTime, IsSecondsSince1900) {
  EXPECT_EQ(osc_time(k1970), 2'208'988'800 * kSecond);
  EXPECT_EQ(osc_time(k1970 + 1500ms), 2'208'988'801 * kSecond + kSecond / 2);
  EXPECT_EQ(osc_time(k1970 - 250ms), 2'208'988'799 * kSecond + kSecond / 4 * 3);
  EXPECT_EQ(osc_time(kRound), 0U);
  EXPECT_EQ(osc_time(kRound + 1s), kSecond);
}

TEST(OscTime, IsAsFarApartAsTheTimesThatItIsOf) {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::int64_t> any(-2'000'000'000'000'000'000, 2'000'000'000'000'000'000);
  for (int i = 0; i < 10'000; ++i) {
    const nanoseconds apart(any(random) >> (i % 60));
    const WallTime day = kRound + nanoseconds(any(random) >> (i % 50));
    ASSERT_EQ(between(osc_time(day), osc_time(day + apart)), apart) << apart.count();
  }
}

TEST(OscMoments, AreOfTheClockAndCrossTheEndOfTheCount) {
  OscMoments moments;
  moments.look(kRound - 100ms, 5000s);
  EXPECT_EQ(moments.due(osc_time(kRound + 150ms)), 5000s + 250ms);
  EXPECT_EQ(moments.due(osc_time(kRound - 1h)), 5000s + 100ms - 1h);
  EXPECT_EQ(moments.due(kOscAtOnce), 5000s);
}

TEST(OscMoments, OfTheSameTimeAreTheSameHoweverLongTheReadingTook) {
  OscMoments moments;
  moments.look(k1970, 10s);
  const nanoseconds due = moments.due(osc_time(k1970 + 3s));
  for (int i = 1; i < 100; ++i) {
    moments.look(k1970 + i * 10ms + (i % 3 - 1) * 900us, 10s + i * 10ms);
    ASSERT_EQ(moments.due(osc_time(k1970 + 3s)), due) << i;
  }
}

TEST(OscMoments, FollowATimeOfDayThatJumps) {
  OscMoments moments;
  moments.look(k1970, 10s);
  moments.look(k1970 + 1h, 11s);
  EXPECT_EQ(moments.due(osc_time(k1970 + 1h + 2s)), 13s);
  moments.look(k1970, 12s);
  EXPECT_EQ(moments.due(osc_time(k1970 + 2s)), 14s);
}

TEST(DueQueue, GivesWhatIsDueInTheOrderOfTimesAndThenOfComing) {
  DueQueue<int, 5> queue;
  EXPECT_EQ(queue.next(), nanoseconds::max());
  EXPECT_EQ(queue.take(nanoseconds::max()), std::nullopt);
  queue.add(3s, 30);
  queue.add(1s, 10);
  queue.add(3s, 31);
  queue.add(2s, 20);
  queue.add(3s, 32);
  EXPECT_EQ(queue.next(), 1s);
  EXPECT_EQ(queue.take(1s - 1ns), std::nullopt);
  EXPECT_EQ(queue.take(1s), 10);
  EXPECT_EQ(queue.take(1s), std::nullopt);
  for (const int expected : {20, 30, 31, 32}) EXPECT_EQ(queue.take(10s), expected);
  EXPECT_EQ(queue.take(10s), std::nullopt);
}

TEST(DueQueue, TakesNoMoreThanItHolds) {
  DueQueue<std::unique_ptr<int>, 2> queue;
  EXPECT_EQ(queue.room(), 2U);
  EXPECT_TRUE(queue.add(1s, std::make_unique<int>(1)));
  EXPECT_TRUE(queue.add(1s, std::make_unique<int>(2)));
  EXPECT_EQ(queue.room(), 0U);
  EXPECT_FALSE(queue.add(0s, std::make_unique<int>(3)));
  EXPECT_EQ(*queue.take(1s).value(), 1);
  EXPECT_TRUE(queue.add(1s, std::make_unique<int>(4)));
}

}  // namespace
}  // namespace cupola
