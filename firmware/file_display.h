// A display whose frames go to files: numbered PNGs, a video, whatever writes them.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>

#include "hal/display/display.h"
#include "hal/time/clock.h"
#include "pipeline/frame/image.h"

namespace cupola {

// A frame that is shown again is written again. Takes frames at any time.
class FileDisplay final : public Display {
 public:
  // `write` may throw: then the display is lost. `clock` is borrowed for the display's life.
  FileDisplay(Clock& clock, Size size, std::function<void(const Image&)> write);

  DisplayBuffer back_buffer() noexcept override;
  Presented present(std::chrono::nanoseconds when) noexcept override;
  Presented repeat(std::chrono::nanoseconds when) noexcept override { return present(when); }
  std::chrono::nanoseconds period() const noexcept override { return std::chrono::nanoseconds(0); }
  const char* trouble() const noexcept override { return trouble_.c_str(); }

 private:
  Clock& clock_;
  std::function<void(const Image&)> write_;
  ImageBuffer frame_;
  bool presented_ = false;  // the frame holds what was written last
  std::string trouble_;
};

}  // namespace cupola
