// A filter of two states, place and rate, whose gains fall from those of least squares to constant ones.
// SPDX-License-Identifier: MIT
#include "hal/sound/sound_clock.h"

#include <algorithm>
#include <cmath>

namespace cupola {

using std::chrono::nanoseconds;

namespace {

constexpr std::int64_t kMemory = 3000;  // calls
// As if the nominal rate had been seen so often before: crystals are within 1000 ppm, first calls are not.
constexpr std::int64_t kTrust = 300;
constexpr double kMostFaster = 0.002;
constexpr double kLost = 0.05;  // seconds off the line: the stream stood still

double seconds(nanoseconds time) {
  return static_cast<double>(time.count()) * 1e-9;
}

}  // namespace

void SoundClock::note(std::int64_t frames, nanoseconds at) noexcept {
  const auto heard = static_cast<double>(frames);
  const double wrong = heard - heard_at(at);
  if (noted_ == 0 || std::abs(wrong) > kLost * rate_) {
    frames_ = heard;
    at_ = at;
    noted_ = 1;
    return;
  }
  const double passed = seconds(at - at_);
  if (passed <= 0.0) return;
  noted_ = std::min(noted_ + 1, kMemory);
  noted_ever_ = std::min(noted_ever_ + 1, kMemory);
  const auto n = static_cast<double>(noted_);
  const auto m = static_cast<double>(noted_ever_ + kTrust);
  frames_ += passed * rate_ * (1.0 + faster_) + 2.0 * (2.0 * n - 1.0) / (n * (n + 1.0)) * wrong;
  at_ = at;
  faster_ = std::clamp(faster_ + 6.0 / (m * (m + 1.0)) * wrong / (passed * rate_), -kMostFaster, kMostFaster);
}

double SoundClock::heard_at(nanoseconds at) const noexcept {
  return frames_ + seconds(at - at_) * rate_ * (1.0 + faster_);
}

nanoseconds SoundClock::time_of(double frame) const noexcept {
  return at_ + nanoseconds(std::llround(1e9 * (frame - frames_) / (rate_ * (1.0 + faster_))));
}

}  // namespace cupola
