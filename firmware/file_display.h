// A display that writes every frame it is given to a numbered PNG file.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "hal/display/display.h"
#include "hal/time/clock.h"
#include "pipeline/frame/image.h"
#include "pipeline/frame/numbered_frames.h"

namespace cupola {

// The first frame has the number 1. A frame that is shown again is written again. Takes frames at any time.
class FileDisplay final : public Display {
 public:
  // `clock` is borrowed for the display's life. Throws Failure where the folder cannot be made.
  FileDisplay(Clock& clock, const std::filesystem::path& folder, const std::string& name, Size size);

  DisplayBuffer back_buffer() noexcept override;
  Presented present(std::chrono::nanoseconds when) noexcept override;
  Presented repeat(std::chrono::nanoseconds when) noexcept override { return present(when); }
  std::chrono::nanoseconds period() const noexcept override { return std::chrono::nanoseconds(0); }
  const char* trouble() const noexcept override { return trouble_.c_str(); }

 private:
  Clock& clock_;
  NumberedFrames files_;
  ImageBuffer frame_;
  std::int64_t count_ = 0;
  std::string trouble_;
};

}  // namespace cupola
