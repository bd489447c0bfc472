// One frame's memory goes to the loop and back.
// SPDX-License-Identifier: MIT
#include "firmware/screenshots.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <exception>
#include <system_error>

#include "hal/time/wall_time.h"
#include "pipeline/frame/error.h"
#include "pipeline/frame/still.h"

namespace cupola {

Screenshots::Screenshots(Size frame, Keep keep, EventLog& log)
    : frame_(frame), keep_(std::move(keep)), log_(log), side_([this] { work(); }) {}

void Screenshots::ask() noexcept {
  asked_.store(true);
  side_.ring();
}

void Screenshots::give_back(Screenshot* taken) noexcept {
  handover_.give_back(taken);
  side_.ring();
}

void Screenshots::work() {
  if (handover_.returned()) {
    lent_ = false;
    write();
  }
  if (lent_ || !asked_.exchange(false)) return;
  try {
    if (screenshot_.frame.empty()) {
      screenshot_.frame = ImageBuffer(PixelFormat::kXrgb8888, frame_);
      blacken(screenshot_.frame.pixels());  // its pages are there before the loop comes to them
    }
  } catch (const std::exception& error) {
    return log_.warn(Topic::kControl, fmt::format("screenshot: {}", error.what()));
  }
  lent_ = true;
  handover_.offer(&screenshot_);
}

void Screenshots::write() noexcept {
  try {
    if (screenshot_.light < kWholeWeight) {
      WorkerPool alone(1);
      if (dimmed_.empty()) dimmed_ = ImageBuffer(PixelFormat::kXrgb8888, frame_);
      dim(as_const(screenshot_.frame.pixels()), screenshot_.light, dimmed_.pixels(), alone);
      std::swap(dimmed_, screenshot_.frame);
    }
    log_.info(Topic::kControl, fmt::format("screenshot: {}", keep_(screenshot_)));
  } catch (const std::exception& error) {
    log_.warn(Topic::kControl, fmt::format("screenshot: {}", error.what()));
  }
}

Screenshots::Keep screenshot_writer(std::filesystem::path folder, std::string name) {
  return [folder = std::move(folder), name = std::move(name)](const Screenshot& taken) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw Failure(fmt::format("{}: {}", folder.string(), error.message()));
    const auto now = std::chrono::time_point_cast<std::chrono::seconds>(wall_time());
    const std::string stem = fmt::format("{}-cue-{}-{:.3f}s-{:%Y%m%dT%H%M%SZ}", name, taken.cue + 1,
                                         static_cast<double>(taken.position.count()) / 1e9, fmt::gmtime(now));
    std::filesystem::path file = folder / (stem + ".png");
    for (int again = 2; std::filesystem::exists(file, error); ++again) {
      file = folder / fmt::format("{}-{}.png", stem, again);
    }
    write_png(file, taken.frame.pixels());
    return file.string();
  };
}

}  // namespace cupola
