// What every display promises, run on each of them.
// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>

#include <gtest/gtest.h>

#include "hal/display/display.h"
#include "hal/display/fake_display.h"
#include "hal/time/clock.h"

#ifdef CUPOLA_WINDOW
#include <SDL.h>

#include "hal/display/window_display.h"
#include "tests/hal/desktop.h"
#endif

namespace cupola {
namespace {

using namespace std::chrono_literals;

// A display ready for use, with the clock that it goes by and a way for the operator to close it.
struct Stage {
  virtual ~Stage() = default;
  virtual Clock& clock() = 0;
  virtual Display& display() = 0;
  virtual void close() = 0;
};

template <class AnyClock>
struct FakeStage final : Stage {
  FakeStage(int width, int height) : fake(time, width, height) {}
  Clock& clock() override { return time; }
  Display& display() override { return fake; }
  void close() override { fake.close(); }
  AnyClock time;
  FakeDisplay fake;
};

#ifdef CUPOLA_WINDOW
struct WindowStage final : Stage {
  WindowStage(int width, int height) : window(time, "contract", width, height) {}
  Clock& clock() override { return time; }
  Display& display() override { return window; }
  void close() override {
    SDL_Event event{};
    event.type = SDL_QUIT;
    SDL_PushEvent(&event);
  }
  MonotonicClock time;
  WindowDisplay window;
};

struct DriverlessWindow final : Stage {
  DriverlessWindow(int width, int height) {
    setenv("SDL_VIDEODRIVER", "dummy", 1);
    stage = std::make_unique<WindowStage>(width, height);
  }
  Clock& clock() override { return stage->clock(); }
  Display& display() override { return stage->display(); }
  void close() override { stage->close(); }
  std::unique_ptr<WindowStage> stage;
};

struct DesktopWindow final : Stage {
  DesktopWindow(int width, int height) : stage(std::make_unique<WindowStage>(width, height)) {}
  Clock& clock() override { return stage->clock(); }
  Display& display() override { return stage->display(); }
  void close() override { stage->close(); }
  Desktop desktop;
  std::unique_ptr<WindowStage> stage;
};
#endif

struct StageMaker {
  const char* name;
  std::unique_ptr<Stage> (*make)(int width, int height);
};
void PrintTo(const StageMaker& maker, std::ostream* out) {
  *out << maker.name;
}

template <class AnyStage>
std::unique_ptr<Stage> make_stage(int width, int height) {
  return std::make_unique<AnyStage>(width, height);
}

class DisplayContract : public testing::TestWithParam<StageMaker> {
 protected:
  std::unique_ptr<Stage> stage_ = GetParam().make(64, 48);
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
    EXPECT_GE(shown.flipped_at, when);
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
    EXPECT_GE(shown.flipped_at, when);
    before = shown.flipped_at;
  }
  stage_->close();
  EXPECT_EQ(display_.repeat(before).result, Present::kClosed);
}

TEST_P(DisplayContract, KeepsItsPeriod) {
  EXPECT_GE(display_.period(), 0ns);
  EXPECT_LT(display_.period(), 1s);
}

TEST_P(DisplayContract, StaysClosedOnceClosed) {
  fill(0xff0000ffU);
  EXPECT_EQ(display_.present(clock_.now()).result, Present::kShown);
  stage_->close();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NE(display_.back_buffer().data, nullptr);
    EXPECT_EQ(display_.present(clock_.now()).result, Present::kClosed);
  }
}

TEST_P(DisplayContract, CanBeOpenedAgainAndAgain) {
  for (const int side : {1, 2, 500}) {
    stage_.reset();
    stage_ = GetParam().make(side, side);
    EXPECT_EQ(stage_->display().back_buffer().width, side);
    EXPECT_EQ(stage_->display().present(0ns).result, Present::kShown);
  }
}

const StageMaker kStages[] = {
    {"FakeOnFakeTime", make_stage<FakeStage<FakeClock>>},
    {"FakeOnRealTime", make_stage<FakeStage<MonotonicClock>>},
#ifdef CUPOLA_WINDOW
    {"WindowWithoutDesktop", make_stage<DriverlessWindow>},
    {"WindowOnADesktop", make_stage<DesktopWindow>},
#endif
};
INSTANTIATE_TEST_SUITE_P(All, DisplayContract, testing::ValuesIn(kStages),
                         [](const auto& maker) { return std::string(maker.param.name); });

}  // namespace
}  // namespace cupola
