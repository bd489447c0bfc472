// A display that writes every frame it is given into a Y4M video, a file or a pipe.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "hal/display/display.h"
#include "hal/time/clock.h"
#include "pipeline/frame/image.h"
#include "pipeline/frame/y4m_writer.h"

namespace cupola {

// A frame that is shown again is written again. Takes frames at any time.
class VideoDisplay final : public Display {
 public:
  // "-" is standard output. `clock` is borrowed for the display's life. Throws Failure.
  VideoDisplay(Clock& clock, const std::filesystem::path& path, Size size, double rate);

  DisplayBuffer back_buffer() noexcept override;
  Presented present(std::chrono::nanoseconds when) noexcept override;
  Presented repeat(std::chrono::nanoseconds when) noexcept override { return present(when); }
  std::chrono::nanoseconds period() const noexcept override { return std::chrono::nanoseconds(0); }
  const char* trouble() const noexcept override { return trouble_.c_str(); }

  // Once, after the last frame: only then the file has its name. Throws Failure.
  void finish() { video_.finish(); }

 private:
  Clock& clock_;
  Y4mWriter video_;
  ImageBuffer frame_;
  std::string trouble_;
};

}  // namespace cupola
