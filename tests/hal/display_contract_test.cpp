// The contract of displays, on those that every machine has.
// SPDX-License-Identifier: MIT
#include "tests/hal/display_contract.h"

#include <cstdlib>
#include <type_traits>

#include "hal/display/fake_display.h"

#ifdef CUPOLA_WINDOW
#include <SDL.h>

#include "hal/display/window_display.h"
#include "tests/hal/desktop.h"
#endif

namespace cupola {
namespace {

template <class AnyClock>
struct FakeStage final : DisplayStage {
  FakeStage(int width, int height) : fake(time, width, height) {}
  Clock& clock() override { return time; }
  Display& display() override { return fake; }
  bool close() override {
    fake.close();
    return true;
  }
  bool unplug() override {
    fake.set_absences({{0ns, 1h * 1000000}});
    return true;
  }
  void plug() override { fake.set_absences({}); }
  std::chrono::nanoseconds slack() const override { return std::is_same_v<AnyClock, FakeClock> ? 0ns : 1s; }
  AnyClock time;
  FakeDisplay fake;
};

#ifdef CUPOLA_WINDOW
struct WindowStage final : DisplayStage {
  WindowStage(int width, int height) : window(time, "contract", width, height) {}
  Clock& clock() override { return time; }
  Display& display() override { return window; }
  bool close() override {
    SDL_Event event{};
    event.type = SDL_QUIT;
    SDL_PushEvent(&event);
    return true;
  }
  MonotonicClock time;
  WindowDisplay window;
};

struct DriverlessWindow final : DisplayStage {
  DriverlessWindow(int width, int height) {
    setenv("SDL_VIDEODRIVER", "dummy", 1);
    stage = std::make_unique<WindowStage>(width, height);
  }
  Clock& clock() override { return stage->clock(); }
  Display& display() override { return stage->display(); }
  bool close() override { return stage->close(); }
  std::unique_ptr<WindowStage> stage;
};

struct DesktopWindow final : DisplayStage {
  DesktopWindow(int width, int height) : stage(std::make_unique<WindowStage>(width, height)) {}
  Clock& clock() override { return stage->clock(); }
  Display& display() override { return stage->display(); }
  bool close() override { return stage->close(); }
  Desktop desktop;
  std::unique_ptr<WindowStage> stage;
};
#endif

const DisplayStageMaker kStages[] = {
    {"FakeOnFakeTime", make_display_stage<FakeStage<FakeClock>>},
    {"FakeOnRealTime", make_display_stage<FakeStage<MonotonicClock>>},
#ifdef CUPOLA_WINDOW
    {"WindowWithoutDesktop", make_display_stage<DriverlessWindow>},
    {"WindowOnADesktop", make_display_stage<DesktopWindow>},
#endif
};
INSTANTIATE_TEST_SUITE_P(All, DisplayContract, testing::ValuesIn(kStages),
                         [](const auto& maker) { return std::string(maker.param.name); });

}  // namespace
}  // namespace cupola
