// A mean in the round, half a step towards it, and a dead band about it.
// SPDX-License-Identifier: MIT
#include "pipeline/source/exposure_drive.h"

#include <algorithm>
#include <cmath>

namespace cupola {

using std::chrono::nanoseconds;

namespace {

constexpr int kGrid = 24;  // texels a side that are looked at
constexpr nanoseconds kSettles{300'000'000};
constexpr double kGamma = 2.2;      // light from encoded values, about
constexpr double kShare = 0.5;      // of the error that a step mends
constexpr double kMostStops = 0.5;  // a step
constexpr double kFar = 0.3;        // stops: begins to move ...
constexpr double kNear = 0.1;       // ... until it is so near
constexpr double kDarkest = 0.01;   // what is darker is as dark

// 0 to 1.
double brightness_at(const NativeImage& face, int x, int y) {
  if (is_rgb(face.layout)) {
    return (0.299 * *sample_at(face, 0, x, y) + 0.587 * *sample_at(face, 1, x, y) +
            0.114 * *sample_at(face, 2, x, y)) /
           255.0;
  }
  const double luma = *sample_at(face, 0, x, y);
  const double level = face.colour.range == YuvRange::kLimited ? (luma - 16.0) / 219.0 : luma / 255.0;
  return std::clamp(level, 0.0, 1.0);
}

double mean_of(const NativeImage& face, const TexelBox& box) {
  double sum = 0.0;
  for (int j = 0; j < kGrid; ++j) {
    const int y = box.y0 + (2 * j + 1) * (box.y1 - box.y0) / (2 * kGrid);
    for (int i = 0; i < kGrid; ++i) {
      sum += brightness_at(face, box.x0 + (2 * i + 1) * (box.x1 - box.x0) / (2 * kGrid), y);
    }
  }
  return sum / (kGrid * kGrid);
}

}  // namespace

ExposureDrive::ExposureDrive(const ExposureLimits& limits, std::vector<TexelBox> looked_at)
    : limits_(limits),
      looked_at_(std::move(looked_at)),
      exposure_{limits.longest_us, 1.0},
      stops_(std::log2(limits.longest_us)) {}

bool ExposureDrive::look(std::span<const NativeImage> faces, unsigned seen, nanoseconds now) noexcept {
  if (now < begins_) return false;
  const std::size_t v = next_++;
  if ((seen >> v & 1) != 0 && !looked_at_[v].empty()) {
    sum_ += mean_of(faces[v], looked_at_[v]);
    ++count_;
  }
  if (next_ < looked_at_.size()) return false;
  next_ = 0;
  const bool any = count_ > 0;
  if (any) brightness_ = sum_ / count_;
  sum_ = 0.0;
  count_ = 0;
  return any && decide(now);
}

bool ExposureDrive::decide(nanoseconds now) noexcept {
  const double error = kGamma * std::log2(limits_.brightness / std::max(brightness_, kDarkest));
  moving_ = std::abs(error) > (moving_ ? kNear : kFar);
  if (!moving_) return false;
  const double least = std::log2(limits_.shortest_us);
  const double most = std::log2(limits_.longest_us * limits_.most_gain);
  stops_ = std::clamp(stops_ + std::clamp(kShare * error, -kMostStops, kMostStops), least, most);
  const double all = std::exp2(stops_);
  // Gain is noise: only what exposure has not.
  const Exposure before = exposure_;
  exposure_.us = std::min(all, limits_.longest_us);
  exposure_.gain = std::max(1.0, all / limits_.longest_us);
  if (exposure_ == before) return false;
  begins_ = now + kSettles;
  return true;
}

}  // namespace cupola
