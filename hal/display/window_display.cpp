// The window: one streaming texture, written to in place.
// SPDX-License-Identifier: MIT
#include "hal/display/window_display.h"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

#include <SDL.h>

namespace cupola {
namespace {

[[noreturn]] void fail() {
  throw std::runtime_error(std::string("window: ") + SDL_GetError());
}

}  // namespace

WindowDisplay::Video::Video() {
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
  SDL_SetHint(SDL_HINT_RENDER_SCALE_QUALITY, "linear");
  if (SDL_InitSubSystem(SDL_INIT_VIDEO) != 0) fail();
}
WindowDisplay::Video::~Video() {
  SDL_QuitSubSystem(SDL_INIT_VIDEO);
}

void WindowDisplay::Destroy::operator()(SDL_Window* window) const {
  SDL_DestroyWindow(window);
}
void WindowDisplay::Destroy::operator()(SDL_Renderer* renderer) const {
  SDL_DestroyRenderer(renderer);
}
void WindowDisplay::Destroy::operator()(SDL_Texture* texture) const {
  SDL_DestroyTexture(texture);
}

WindowDisplay::WindowDisplay(Clock& clock, const std::string& title, int width, int height)
    : clock_(clock), width_(width), height_(height) {
  if (width < 1 || height < 1) throw std::runtime_error("window: expected at least one pixel");
  // Without a desktop SDL falls back to a driver that shows nothing; only who names that one wants it.
  const std::string_view driver = SDL_GetCurrentVideoDriver() ? SDL_GetCurrentVideoDriver() : "";
  if ((driver == "dummy" || driver == "offscreen") && std::getenv("SDL_VIDEODRIVER") == nullptr) {
    throw std::runtime_error("window: there is no desktop to open it on");
  }
  SDL_Rect desk{0, 0, width, height};
  SDL_GetDisplayUsableBounds(0, &desk);
  const double scale = std::min({1.0, 0.9 * desk.w / width, 0.9 * desk.h / height});
  window_.reset(SDL_CreateWindow(title.c_str(), SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED,
                                 std::max(1, static_cast<int>(width * scale)),
                                 std::max(1, static_cast<int>(height * scale)), SDL_WINDOW_RESIZABLE));
  if (!window_) fail();
  renderer_.reset(SDL_CreateRenderer(window_.get(), -1, SDL_RENDERER_PRESENTVSYNC));
  if (!renderer_) renderer_.reset(SDL_CreateRenderer(window_.get(), -1, SDL_RENDERER_SOFTWARE));
  if (!renderer_) fail();
  SDL_RendererInfo info{};
  SDL_DisplayMode mode{};
  const bool software =
      SDL_GetRendererInfo(renderer_.get(), &info) != 0 || (info.flags & SDL_RENDERER_SOFTWARE) != 0;
  if (software) {
    SDL_RenderSetVSync(renderer_.get(),
                       0);  // SDL would imitate it by sleeping; whoever calls us paces better
  } else if ((info.flags & SDL_RENDERER_PRESENTVSYNC) != 0 &&
             SDL_GetCurrentDisplayMode(SDL_GetWindowDisplayIndex(window_.get()), &mode) == 0 &&
             mode.refresh_rate > 0) {
    period_ = std::chrono::nanoseconds(std::chrono::seconds(1)) / mode.refresh_rate;
  }
  texture_.reset(SDL_CreateTexture(renderer_.get(), SDL_PIXELFORMAT_XRGB8888, SDL_TEXTUREACCESS_STREAMING,
                                   width, height));
  if (!texture_) fail();
  if (SDL_RenderSetLogicalSize(renderer_.get(), width, height) != 0) fail();
}

WindowDisplay::~WindowDisplay() = default;

DisplayBuffer WindowDisplay::back_buffer() noexcept {
  if (locked_.data) return locked_;
  void* pixels = nullptr;
  int stride = 0;
  if (SDL_LockTexture(texture_.get(), nullptr, &pixels, &stride) != 0) {
    lost_ = true;
    return {nullptr, 0, width_, height_};
  }
  locked_ = {static_cast<std::byte*>(pixels), stride, width_, height_};
  return locked_;
}

Presented WindowDisplay::present(std::chrono::nanoseconds when) noexcept {
  if (locked_.data) SDL_UnlockTexture(texture_.get());
  locked_ = {};
  return repeat(when);
}

Presented WindowDisplay::repeat(std::chrono::nanoseconds when) noexcept {
  handle_events();
  if (closed_) return {Present::kClosed, clock_.now()};
  if (lost_) return {Present::kLost, clock_.now()};
  // Half a period early: with vertical sync SDL_RenderPresent waits for the flip itself.
  clock_.sleep_until(when - period_ / 2);
  const bool drawn = SDL_RenderClear(renderer_.get()) == 0 &&
                     SDL_RenderCopy(renderer_.get(), texture_.get(), nullptr, nullptr) == 0;
  SDL_RenderPresent(renderer_.get());
  clock_.sleep_until(when);
  return {drawn ? Present::kShown : Present::kLost, clock_.now()};
}

void WindowDisplay::handle_events() noexcept {
  SDL_Event event;
  while (SDL_PollEvent(&event) != 0) {
    if (event.type == SDL_QUIT ||
        (event.type == SDL_WINDOWEVENT && event.window.event == SDL_WINDOWEVENT_CLOSE)) {
      closed_ = true;
    }
    if (event.type != SDL_KEYDOWN || event.key.repeat != 0) continue;
    const SDL_Keycode key = event.key.keysym.sym;
    if (key == SDLK_ESCAPE || key == SDLK_q) closed_ = true;
    if (on_key_ && key == SDLK_LEFT) on_key_('<');
    if (on_key_ && key == SDLK_RIGHT) on_key_('>');
    if (on_key_ && (key == SDLK_PLUS || key == SDLK_EQUALS || key == SDLK_KP_PLUS)) on_key_('+');
    if (on_key_ && (key == SDLK_MINUS || key == SDLK_KP_MINUS)) on_key_('-');
    const bool letter = key >= SDLK_a && key <= SDLK_z && key != SDLK_q && key != SDLK_f;
    if (on_key_ && (key == SDLK_SPACE || letter)) on_key_(static_cast<char>(key));
    if (key == SDLK_f) {
      fullscreen_ = !fullscreen_;
      SDL_SetWindowFullscreen(window_.get(), fullscreen_ ? SDL_WINDOW_FULLSCREEN_DESKTOP : 0);
      SDL_ShowCursor(fullscreen_ ? SDL_DISABLE : SDL_ENABLE);
    }
  }
}

}  // namespace cupola
