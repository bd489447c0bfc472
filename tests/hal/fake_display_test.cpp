// The fake display's own promises: exact flips, and the last frame to look at.
// SPDX-License-Identifier: MIT
#include "hal/display/fake_display.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace cupola {
namespace {

using namespace std::chrono_literals;

TEST(FakeDisplay, FlipsAtMultiplesOfItsPeriod) {
  FakeClock clock;
  FakeDisplay display(clock, 4, 2, 10ms);
  EXPECT_EQ(display.present(0ms).flipped_at, 10ms);
  EXPECT_EQ(display.present(0ms).flipped_at, 20ms);
  EXPECT_EQ(display.present(20ms).flipped_at, 30ms);
  EXPECT_EQ(display.present(31ms).flipped_at, 40ms);
  EXPECT_EQ(display.present(50ms).flipped_at, 50ms);
  clock.advance(27ms);
  EXPECT_EQ(display.present(60ms).flipped_at, 80ms);
  EXPECT_EQ(clock.now(), 80ms);
  EXPECT_EQ(display.frames(), 6);
}

TEST(FakeDisplay, FlipsAtSixtyHertzByDefault) {
  FakeClock clock;
  FakeDisplay display(clock, 4, 2);
  for (int i = 0; i < 60; ++i) display.present(0ns);
  EXPECT_NEAR(std::chrono::duration<double>(clock.now()).count(), 1.0, 1e-6);
}

TEST(FakeDisplay, KeepsTheLastFrame) {
  FakeClock clock;
  FakeDisplay display(clock, 3, 2, 1ms);
  const std::uint64_t black = display.front_hash();
  const DisplayBuffer back = display.back_buffer();
  reinterpret_cast<std::uint32_t*>(back.data)[5] = 0xff123456U;
  EXPECT_EQ(display.front_hash(), black);
  display.present(0ns);
  EXPECT_EQ(display.front_buffer().data, back.data);
  EXPECT_NE(display.front_hash(), black);
  EXPECT_NE(display.back_buffer().data, back.data);
}

TEST(FakeDisplay, KeepsTheFrameOnTheScreenWhenItRepeats) {
  FakeClock clock;
  FakeDisplay display(clock, 3, 2, 1ms);
  display.present(0ns);
  const std::byte* front = display.front_buffer().data;
  EXPECT_EQ(display.repeat(0ns).flipped_at, 2ms);
  EXPECT_EQ(display.front_buffer().data, front);
  EXPECT_EQ(display.frames(), 2);
}

TEST(FakeDisplay, IsLostWhenToldTo) {
  FakeClock clock;
  FakeDisplay display(clock, 3, 2, 1ms);
  display.lose();
  EXPECT_EQ(display.present(0ns).result, Present::kLost);
  EXPECT_EQ(display.frames(), 0);
}

TEST(FakeDisplay, IsAwayForAWhileAndKeepsItsFlipTimes) {
  FakeClock clock;
  FakeDisplay display(clock, 3, 2, 10ms);
  display.set_absences({{15ms, 35ms}});
  EXPECT_EQ(display.present(0ms).result, Present::kShown);
  for (const auto flip : {20ms, 30ms}) {
    const Presented away = display.repeat(0ms);
    EXPECT_EQ(away.result, Present::kAway);
    EXPECT_EQ(away.flipped_at, flip);
    EXPECT_EQ(clock.now(), flip);
    EXPECT_STREQ(display.trouble(), "unplugged on demand");
  }
  EXPECT_EQ(display.repeat(0ms).result, Present::kShown);
  EXPECT_EQ(clock.now(), 40ms);
  EXPECT_EQ(display.frames(), 2);
}

TEST(FakeDisplay, ComesBackWithAnotherPeriod) {
  FakeClock clock;
  FakeDisplay display(clock, 3, 2, 10ms);
  display.set_absences({{10ms, 20ms, 5ms}, {30ms, 40ms, 20ms}});
  EXPECT_EQ(display.present(0ms).result, Present::kAway);
  EXPECT_EQ(display.period(), 10ms);
  EXPECT_EQ(display.present(0ms).flipped_at, 20ms);
  EXPECT_EQ(display.period(), 5ms);
  EXPECT_EQ(display.present(0ms).flipped_at, 25ms);
  EXPECT_EQ(display.present(38ms).flipped_at, 40ms);
  EXPECT_EQ(display.present(0ms).flipped_at, 60ms);
}

TEST(FakeDisplay, RefusesSizesAndPeriodsThatAreNone) {
  FakeClock clock;
  EXPECT_THROW(FakeDisplay(clock, 0, 2), std::runtime_error);
  EXPECT_THROW(FakeDisplay(clock, 2, 65536), std::runtime_error);
  EXPECT_THROW(FakeDisplay(clock, 2, 2, 0ns), std::runtime_error);
}

}  // namespace
}  // namespace cupola
