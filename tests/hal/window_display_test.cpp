// The window on a real X server: the pixels that arrive, the keys, the shape.
// SPDX-License-Identifier: MIT
#include "hal/display/window_display.h"

#include <cstring>
#include <string>
#include <vector>

#include <SDL.h>
#include <gtest/gtest.h>

#include "tests/hal/desktop.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;

class Window : public testing::Test {
 protected:
  static constexpr int kWidth = 64;
  static constexpr int kHeight = 48;

  static std::uint32_t colour(int x, int y) {
    return 0xff000000U + static_cast<std::uint32_t>(x * 4) * 0x10000U +
           static_cast<std::uint32_t>(y * 5) * 0x100U + 77U;
  }
  Present show() {
    const DisplayBuffer buffer = window_.back_buffer();
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const std::uint32_t word = colour(x, y);
        std::memcpy(buffer.data + y * buffer.stride + 4 * x, &word, 4);
      }
    }
    return window_.present(0ns).result;
  }
  SDL_Window* sdl_window() const {
    for (std::uint32_t id = 1; id < 100; ++id) {
      if (SDL_Window* window = SDL_GetWindowFromID(id)) return window;
    }
    return nullptr;
  }
  // The window's pixels, as shown.
  std::vector<std::uint32_t> pixels(int width, int height) const {
    std::vector<std::uint32_t> words(static_cast<std::size_t>(width * height));
    SDL_Renderer* renderer = SDL_GetRenderer(sdl_window());
    SDL_RenderSetLogicalSize(renderer, 0, 0);
    EXPECT_EQ(SDL_RenderReadPixels(renderer, nullptr, SDL_PIXELFORMAT_ARGB8888, words.data(), 4 * width), 0);
    SDL_RenderSetLogicalSize(renderer, kWidth, kHeight);
    return words;
  }
  void press(SDL_Keycode key) {
    SDL_Event event{};
    event.type = SDL_KEYDOWN;
    event.key.keysym.sym = key;
    SDL_PushEvent(&event);
  }

  Desktop desktop_;
  MonotonicClock clock_;
  WindowDisplay window_{clock_, "test", kWidth, kHeight};
};

TEST_F(Window, ShowsThePixelsItWasGiven) {
  EXPECT_EQ(show(), Present::kShown);
  const std::vector<std::uint32_t> shown = pixels(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_EQ(shown[static_cast<std::size_t>(y * kWidth + x)] | 0xff000000U, colour(x, y)) << x << " " << y;
    }
  }
}

TEST_F(Window, HandsOnKeysThatAreNotItsOwn) {
  std::string keys;
  window_.on_key([&](char key) { keys += key; });
  for (const SDL_Keycode key : {SDLK_SPACE, SDLK_b, SDLK_LEFT, SDLK_RIGHT, SDLK_F1, SDLK_f, SDLK_z, SDLK_f}) {
    press(key);
  }
  EXPECT_EQ(show(), Present::kShown);
  EXPECT_EQ(keys, " b<>z");
  press(SDLK_q);
  EXPECT_EQ(show(), Present::kClosed);
  EXPECT_EQ(keys, " b<>z");
}

TEST_F(Window, ShowsTheSamePixelsAgain) {
  EXPECT_EQ(show(), Present::kShown);
  EXPECT_EQ(window_.repeat(0ns).result, Present::kShown);
  EXPECT_EQ(pixels(kWidth, kHeight)[static_cast<std::size_t>(20 * kWidth + 30)] | 0xff000000U,
            colour(30, 20));
}

TEST_F(Window, KeepsTheShapeOfThePictureWhenResized) {
  EXPECT_EQ(show(), Present::kShown);
  SDL_SetWindowSize(sdl_window(), 3 * kWidth, kHeight);
  EXPECT_EQ(show(), Present::kShown);
  EXPECT_EQ(show(), Present::kShown);
  const std::vector<std::uint32_t> shown = pixels(3 * kWidth, kHeight);
  const auto at = [&](int x, int y) {
    return shown[static_cast<std::size_t>(y * 3 * kWidth + x)] & 0xffffffU;
  };
  EXPECT_EQ(at(kWidth / 2, 20), 0U);
  EXPECT_EQ(at(2 * kWidth + kWidth / 2, 20), 0U);
  EXPECT_EQ(at(kWidth + 30, 20), colour(30, 20) & 0xffffffU);
}

TEST_F(Window, EndsOnEscape) {
  press(SDLK_x);
  EXPECT_EQ(show(), Present::kShown);
  press(SDLK_ESCAPE);
  EXPECT_EQ(show(), Present::kClosed);
}

TEST_F(Window, EndsOnQ) {
  press(SDLK_q);
  EXPECT_EQ(show(), Present::kClosed);
}

TEST_F(Window, FillsTheScreenOnFAndComesBack) {
  EXPECT_EQ(show(), Present::kShown);
  press(SDLK_f);
  EXPECT_EQ(show(), Present::kShown);
  EXPECT_NE(SDL_GetWindowFlags(sdl_window()) & SDL_WINDOW_FULLSCREEN_DESKTOP, 0U);
  press(SDLK_f);
  EXPECT_EQ(show(), Present::kShown);
  EXPECT_EQ(SDL_GetWindowFlags(sdl_window()) & SDL_WINDOW_FULLSCREEN_DESKTOP, 0U);
}

TEST(WindowWithoutADesktop, IsRefusedInWords) {
  setenv("SDL_VIDEODRIVER", "x11", 1);
  setenv("DISPLAY", ":987", 1);
  MonotonicClock clock;
  try {
    WindowDisplay window(clock, "test", 8, 8);
    FAIL() << "opened";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()).substr(0, 8), "window: ");
  }
}

}  // namespace
}  // namespace cupola
