// A display that a test looks at, flip by flip, while the loop plays to it.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <thread>
#include <utility>

#include "hal/display/fake_display.h"

namespace cupola::test {

// On the fake clock; asks `next` after each flip whether to go on, and sleeps a little, so that the threads
// beside the loop come to their turn. Allocates nothing itself.
class WatchedDisplay final : public Display {
 public:
  using Next = std::function<bool(int flip, const DisplayBuffer& front)>;

  WatchedDisplay(Clock& clock, int width, int height, Next next)
      : display_(clock, width, height), next_(std::move(next)) {}
  DisplayBuffer back_buffer() noexcept override { return display_.back_buffer(); }
  Presented present(std::chrono::nanoseconds when) noexcept override { return flip(display_.present(when)); }
  Presented repeat(std::chrono::nanoseconds when) noexcept override { return flip(display_.repeat(when)); }
  std::chrono::nanoseconds period() const noexcept override { return display_.period(); }
  const char* trouble() const noexcept override { return ""; }

 private:
  Presented flip(Presented presented) noexcept {
    if (!closed_) closed_ = !next_(flips_++, display_.front_buffer()) || flips_ == 60000;
    if (closed_) display_.close();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return presented;
  }

  FakeDisplay display_;
  Next next_;
  int flips_ = 0;
  bool closed_ = false;
};

}  // namespace cupola::test
