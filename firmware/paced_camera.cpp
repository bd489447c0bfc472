// A timer says when the next picture is there.
// SPDX-License-Identifier: MIT
#include "firmware/paced_camera.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <sys/timerfd.h>
#include <unistd.h>

#include "hal/camera/fake_picture.h"

namespace cupola {

using std::chrono::nanoseconds;

namespace {

constexpr std::size_t kPictures = 8;

}  // namespace

PacedCamera::PacedCamera(Clock& clock, const PacedCameraDevice& device)
    : clock_(clock),
      device_(device),
      timer_(timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)),
      pictures_(kPictures),
      frames_(kPictures),
      lent_(kPictures, false) {
  if (timer_ < 0) throw std::runtime_error("timerfd_create failed");
  const FakePicture picture(device.format, device.width, device.height, device.number);
  for (std::size_t i = 0; i < kPictures; ++i) {
    pictures_[i].resize(picture.bytes());
    picture.prepare(pictures_[i]);
    const std::size_t used = picture.draw(pictures_[i], static_cast<std::uint32_t>(i));
    picture.describe(pictures_[i].data(), used, frames_[i]);
    frames_[i].buffer = static_cast<int>(i);
  }
}

PacedCamera::~PacedCamera() {
  close(timer_);
}

std::variant<CameraMode, CameraTrouble> PacedCamera::start(const CameraSetup& /*setup*/) noexcept {
  stop();
  running_ = true;
  // All of a rate at the same times, as if one line triggered them.
  const nanoseconds period(std::llround(1e9 / device_.rate));
  started_at_ = clock_.now() / period * period;
  next_ = 0;
  wind_timer();
  CameraMode mode;
  mode.format = device_.format;
  mode.width = device_.width;
  mode.height = device_.height;
  mode.rate = device_.rate;
  mode.crop = {0, 0, device_.width, device_.height};
  return mode;
}

void PacedCamera::stop() noexcept {
  running_ = false;
  lent_.assign(kPictures, false);
  const itimerspec never{};
  timerfd_settime(timer_, 0, &never, nullptr);
}

CameraPoll PacedCamera::poll(CameraFrame& frame, CameraTrouble& /*trouble*/) noexcept {
  if (!running_) return CameraPoll::kNothing;
  const nanoseconds at = captured_at(next_);
  if (at + device_.latency > clock_.now()) {
    wind_timer();
    return CameraPoll::kNothing;
  }
  const std::uint64_t sequence = next_++;
  const auto free = std::find(lent_.begin(), lent_.end(), false);
  if (free == lent_.end()) return CameraPoll::kNothing;  // its number will be missing
  *free = true;
  frame = frames_[static_cast<std::size_t>(free - lent_.begin())];
  frame.sequence = sequence;
  frame.captured_at = at;
  return CameraPoll::kFrame;
}

void PacedCamera::give_back(const CameraFrame& frame) noexcept {
  lent_[static_cast<std::size_t>(frame.buffer)] = false;
}

nanoseconds PacedCamera::captured_at(std::uint64_t frame) const noexcept {
  const double even = 1e9 / device_.rate * static_cast<double>(frame + 1);
  // A different lateness for every frame and camera, the same in every run: the golden ratio's multiples.
  const double share =
      std::fmod(0.6180339887498949 * static_cast<double>(frame + 1) + 0.25 * device_.number, 1.0);
  const double late = share * static_cast<double>(device_.jitter.count());
  return started_at_ + nanoseconds(std::llround(even + late));
}

void PacedCamera::wind_timer() noexcept {
  const auto due = (captured_at(next_) + device_.latency).count();
  itimerspec when{};
  when.it_value.tv_sec = due / 1'000'000'000;
  when.it_value.tv_nsec = due % 1'000'000'000;
  timerfd_settime(timer_, TFD_TIMER_ABSTIME, &when, nullptr);
}

}  // namespace cupola
