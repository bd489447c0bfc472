// A track that says at every frame which one it is.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <span>
#include <string>

#include "pipeline/frame/error.h"
#include "pipeline/sound/sound_track.h"

namespace cupola {

// Frame n of every channel is (n + 1) / 2^25: exact while n is small, and to one part in 2^24 for hours.
class FakeTrack final : public SoundTrack {
 public:
  explicit FakeTrack(std::int64_t length, int channels = 1, std::int64_t breaks_at = INT64_MAX)
      : length_(length), channels_(channels), breaks_at_(breaks_at) {}
  static float sample(std::int64_t frame) { return static_cast<float>(frame + 1) * 0x1p-25F; }
  static double frame(double sample) { return sample * 0x1p25 - 1.0; }

  std::string name() const override { return "fake.wav"; }
  std::int64_t length() const override { return length_; }
  std::size_t read(std::int64_t first, std::span<float> into) override {
    const auto channels = static_cast<std::size_t>(channels_);
    if (first >= breaks_at_) throw InputError("fake.wav: is broken there");
    const std::int64_t end = std::min(length_, breaks_at_);
    const auto count = static_cast<std::size_t>(
        std::clamp<std::int64_t>(end - first, 0, static_cast<std::int64_t>(into.size() / channels)));
    for (std::size_t i = 0; i < count * channels; ++i)
      into[i] = sample(first + static_cast<std::int64_t>(i / channels));
    return count;
  }
  std::int64_t damaged() const override { return 0; }
  int file_channels() const override { return channels_; }

 private:
  std::int64_t length_;
  int channels_;
  std::int64_t breaks_at_;
};

}  // namespace cupola
