// A second-order loop, critically damped and slower than the offsets' means.
// SPDX-License-Identifier: MIT
#include "pipeline/source/frame_alignment.h"

#include <algorithm>
#include <cmath>

namespace cupola {

using std::chrono::nanoseconds;

namespace {

constexpr nanoseconds kTurn{500'000'000};
constexpr double kTime = 8.0;          // seconds in which an offset is to go down to a third
constexpr double kShare = 0.25;        // of the drift's error that a turn mends: 4 / kTime a second
constexpr double kMostLonger = 0.005;  // of the period
constexpr nanoseconds kFinest{500};    // drivers count microseconds
constexpr double kNear = 50e-6;        // seconds ...
constexpr double kStill = 10e-6;       // ... and seconds a second: good enough

}  // namespace

FrameAlignment::FrameAlignment(std::size_t cameras, nanoseconds period)
    : period_(period), cameras_(cameras, Camera{nanoseconds(0), 0.0, period}) {}

std::optional<nanoseconds> FrameAlignment::look(std::size_t camera, const SyncOffset& measured,
                                                nanoseconds now) noexcept {
  Camera& aligned = cameras_[camera];
  if (now < aligned.next) return std::nullopt;
  aligned.next = now + kTurn;
  const double offset = 1e-9 * static_cast<double>(measured.offset.count());
  const double drift = 1e-6 * measured.drift_ppm;
  if (std::abs(offset) < kNear && std::abs(drift) < kStill) return std::nullopt;
  const double wanted = -offset / kTime;
  aligned.longer = std::clamp(aligned.longer + kShare * (wanted - drift), -kMostLonger, kMostLonger);
  const auto frame = nanoseconds(std::llround(static_cast<double>(period_.count()) * (1.0 + aligned.longer)));
  if (std::chrono::abs(frame - aligned.told) < kFinest) return std::nullopt;
  aligned.told = frame;
  return frame;
}

}  // namespace cupola
