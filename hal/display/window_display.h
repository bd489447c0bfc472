// A desktop window through SDL2: the picture scaled to fit, F for the whole screen, Esc or q to end.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "hal/display/display.h"
#include "hal/time/clock.h"

struct SDL_Renderer;
struct SDL_Texture;
struct SDL_Window;

namespace cupola {

// Everything on the thread that made it; one at a time.
class WindowDisplay final : public Display {
 public:
  // Throws std::runtime_error where there is no desktop. `clock` is borrowed for the display's life.
  WindowDisplay(Clock& clock, const std::string& title, int width, int height);
  ~WindowDisplay() override;
  WindowDisplay(const WindowDisplay&) = delete;
  WindowDisplay& operator=(const WindowDisplay&) = delete;

  DisplayBuffer back_buffer() noexcept
      override;  // no data where the driver refused it: the next present is kLost
  Presented present(std::chrono::nanoseconds when) noexcept override;
  Presented repeat(std::chrono::nanoseconds when) noexcept override;
  // Called from present() and repeat() for a key that is not the window's own: a space, a small letter, < and
  // > for the arrows. Must not throw.
  void on_key(std::function<void(char)> call) { on_key_ = std::move(call); }
  std::chrono::nanoseconds period() const noexcept override { return period_; }
  const char* trouble() const noexcept override { return "the window's renderer failed"; }

 private:
  struct Video {
    explicit Video();
    ~Video();
  };
  struct Destroy {
    void operator()(SDL_Window* window) const;
    void operator()(SDL_Renderer* renderer) const;
    void operator()(SDL_Texture* texture) const;
  };
  void handle_events() noexcept;

  Clock& clock_;
  Video video_;
  std::unique_ptr<SDL_Window, Destroy> window_;
  std::unique_ptr<SDL_Renderer, Destroy> renderer_;
  std::unique_ptr<SDL_Texture, Destroy> texture_;
  DisplayBuffer locked_;  // data while the texture is locked
  int width_;
  int height_;
  std::chrono::nanoseconds period_{0};
  std::function<void(char)> on_key_;
  bool closed_ = false;
  bool lost_ = false;
  bool fullscreen_ = false;
};

}  // namespace cupola
