// What every display promises: tests that a program includes once and instantiates for the displays it has.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstring>
#include <memory>
#include <ostream>

#include <gtest/gtest.h>

#include "hal/display/display.h"
#include "hal/time/clock.h"

namespace cupola {

using namespace std::chrono_literals;

// A display ready for use, with the clock that it goes by and what can happen to it.
struct DisplayStage {
  virtual ~DisplayStage() = default;
  virtual Clock& clock() = 0;
  virtual Display& display() = 0;
  // The operator closes it; false: nobody can.
  virtual bool close() { return false; }
  // Its screen goes, false where it has none that could, and comes back.
  virtual bool unplug() { return false; }
  virtual void plug() {}
  // What two periods after the return may take longer, where time is real and the machine shared.
  virtual std::chrono::nanoseconds slack() const { return 0ns; }
};

struct DisplayStageMaker {
  const char* name;
  std::unique_ptr<DisplayStage> (*make)(int width, int height);
};
inline void PrintTo(const DisplayStageMaker& maker, std::ostream* out) {
  *out << maker.name;
}

template <class AnyStage>
std::unique_ptr<DisplayStage> make_display_stage(int width, int height) {
  return std::make_unique<AnyStage>(width, height);
}

class DisplayContract : public testing::TestWithParam<DisplayStageMaker> {
 protected:
  std::unique_ptr<DisplayStage> stage_ = GetParam().make(64, 48);
  Clock& clock_ = stage_->clock();
  Display& display_ = stage_->display();

  void fill(std::uint32_t word) {
    const DisplayBuffer buffer = display_.back_buffer();
    ASSERT_NE(buffer.data, nullptr);
    for (int y = 0; y < buffer.height; ++y) {
      for (int x = 0; x < buffer.width; ++x) std::memcpy(buffer.data + y * buffer.stride + 4 * x, &word, 4);
    }
  }
};

TEST_P(DisplayContract, GivesAWholeBufferForEveryFrame) {
  for (std::uint32_t i = 0; i < 5; ++i) {
    const DisplayBuffer buffer = display_.back_buffer();
    ASSERT_NE(buffer.data, nullptr);
    EXPECT_EQ(buffer.width, 64);
    EXPECT_EQ(buffer.height, 48);
    EXPECT_GE(buffer.stride, 4 * 64);
    EXPECT_EQ(display_.back_buffer().data, buffer.data) << "the same until it is presented";
    fill(0xff000000U + i);
    EXPECT_EQ(display_.present(clock_.now()).result, Present::kShown);
  }
}

TEST_P(DisplayContract, BuffersHoldWhatTheirAgeSays) {
  for (std::uint32_t i = 0; i < 9; ++i) {
    const DisplayBuffer buffer = display_.back_buffer();
    ASSERT_LE(buffer.age, static_cast<int>(i));
    if (buffer.age > 0) {
      std::uint32_t word = 0;
      std::memcpy(&word, buffer.data + 47 * buffer.stride + 4 * 63, 4);
      EXPECT_EQ(word, 0xff000000U + i - static_cast<std::uint32_t>(buffer.age));
    }
    fill(0xff000000U + i);
    ASSERT_EQ(display_.present(clock_.now()).result, Present::kShown);
    if (i % 3 == 0) {
      ASSERT_EQ(display_.repeat(clock_.now()).result, Present::kShown);
    }
  }
}

TEST_P(DisplayContract, ShowsNoFrameBeforeItsTime) {
  for (const auto wait : {0ms, 1ms, 20ms, 45ms}) {
    fill(0xff808080U);
    const std::chrono::nanoseconds when = clock_.now() + wait;
    const Presented shown = display_.present(when);
    EXPECT_EQ(shown.result, Present::kShown);
    EXPECT_GE(shown.flipped_at, when - display_.period() / 16);
    EXPECT_GE(clock_.now(), shown.flipped_at) << "returns after the flip";
    EXPECT_LT(shown.flipped_at, when + 1s);
  }
}

TEST_P(DisplayContract, ShowsLateFramesAtOnceAndOneAfterTheOther) {
  std::chrono::nanoseconds before{-1};
  const std::chrono::nanoseconds start = clock_.now();
  for (int i = 0; i < 10; ++i) {
    fill(0xffffffffU);
    const Presented shown = display_.present(start - 1h);
    EXPECT_GT(shown.flipped_at, before);
    before = shown.flipped_at;
  }
  EXPECT_LT(clock_.now(), start + 10 * display_.period() + 2s);
}

TEST_P(DisplayContract, ShowsAFrameAgain) {
  fill(0xff123456U);
  std::chrono::nanoseconds before = display_.present(clock_.now()).flipped_at;
  for (int i = 0; i < 3; ++i) {
    const std::chrono::nanoseconds when = before + 5ms;
    const Presented shown = display_.repeat(when);
    EXPECT_EQ(shown.result, Present::kShown);
    EXPECT_GE(shown.flipped_at, when - display_.period() / 16);
    before = shown.flipped_at;
  }
  if (stage_->close()) {
    EXPECT_EQ(display_.repeat(before).result, Present::kClosed);
  }
}

TEST_P(DisplayContract, KeepsItsPeriod) {
  EXPECT_GE(display_.period(), 0ns);
  EXPECT_LT(display_.period(), 1s);
}

TEST_P(DisplayContract, StaysClosedOnceClosed) {
  fill(0xff0000ffU);
  EXPECT_EQ(display_.present(clock_.now()).result, Present::kShown);
  if (!stage_->close()) return;
  for (int i = 0; i < 3; ++i) {
    EXPECT_NE(display_.back_buffer().data, nullptr);
    EXPECT_EQ(display_.present(clock_.now()).result, Present::kClosed);
  }
}

TEST_P(DisplayContract, IsAwayWhileItsScreenIsAndKeepsThePace) {
  fill(0xff0000ffU);
  ASSERT_EQ(display_.present(clock_.now()).result, Present::kShown);
  for (int loss = 0; loss < 3; ++loss) {
    if (!stage_->unplug()) return;
    std::chrono::nanoseconds before = clock_.now();
    for (int i = 0; i < 20; ++i) {
      const bool again = i % 4 == 3;
      if (!again) fill(0xff0000ffU);
      const Presented away = again ? display_.repeat(before) : display_.present(before);
      ASSERT_EQ(away.result, Present::kAway);
      EXPECT_STRNE(display_.trouble(), "");
      EXPECT_GE(clock_.now(), away.flipped_at);
      EXPECT_LE(away.flipped_at, before + 2 * display_.period() + stage_->slack());
      before = away.flipped_at;
    }
    const std::chrono::nanoseconds back = clock_.now();
    stage_->plug();
    int unshown = 0;
    Presented shown = display_.repeat(back);
    for (; shown.result == Present::kAway && unshown < 100; ++unshown) shown = display_.repeat(back);
    EXPECT_EQ(shown.result, Present::kShown);
    EXPECT_LE(shown.flipped_at, back + 2 * display_.period() + stage_->slack());
  }
}

TEST_P(DisplayContract, CanBeOpenedAgainAndAgain) {
  for (const int side : {1, 2, 500}) {
    stage_.reset();  // a projector takes one owner at a time
    stage_ = GetParam().make(side, side);
    EXPECT_EQ(stage_->display().back_buffer().width, side);
    EXPECT_EQ(stage_->display().present(0ns).result, Present::kShown);
  }
}

}  // namespace cupola
