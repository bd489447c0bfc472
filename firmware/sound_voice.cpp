// A window that moves over the decoded frames.
// SPDX-License-Identifier: MIT
#include "firmware/sound_voice.h"

#include <algorithm>
#include <cmath>

namespace cupola {

namespace {
constexpr std::int64_t kRoom = 1024;  // frames of the window
constexpr std::int64_t kBefore = FineResampler::kBefore;
constexpr std::int64_t kTaps = FineResampler::kTaps;
}  // namespace

SoundVoice::SoundVoice(const FineResampler& resampler, int channels, std::int64_t ramp_frames)
    : resampler_(&resampler),
      channels_(static_cast<std::size_t>(channels)),
      ramp_(1.0 / static_cast<double>(std::max<std::int64_t>(ramp_frames, 1))),
      window_(static_cast<std::size_t>(kRoom * channels)),
      out_(channels_) {}

void SoundVoice::begin(SoundAhead& source, std::int64_t place) noexcept {
  source_ = &source;
  frame_ = place;
  fraction_ = 0.0;
  rise_ = 0.0;
  fall_ = 1.0;
  fall_step_ = 0.0;
  arrived_ = false;
  base_ = place - kBefore;
  held_ = 0;
}

void SoundVoice::end(std::int64_t frames) noexcept {
  fall_step_ = 1.0 / static_cast<double>(std::max<std::int64_t>(frames, 1));
}

// Whether frames [first, first + kTaps) are in the window; where not, it is filled to hold `most`.
bool SoundVoice::have(std::int64_t first, std::int64_t most) noexcept {
  if (first < base_ || first > base_ + held_) {
    base_ = first;
    held_ = 0;
  }
  if (first + kTaps <= base_ + held_) return true;
  const auto channels = static_cast<std::int64_t>(channels_);
  std::copy(window_.begin() + (first - base_) * channels, window_.begin() + held_ * channels,
            window_.begin());
  held_ -= first - base_;
  base_ = first;
  // Before its begin there is silence.
  for (; base_ + held_ < 0 && held_ < most; ++held_)
    std::fill_n(window_.begin() + held_ * channels, channels, 0.0F);
  if (held_ < most) {
    held_ += static_cast<std::int64_t>(source_->read(
        base_ + held_,
        {window_.data() + held_ * channels, static_cast<std::size_t>((most - held_) * channels)}));
  }
  return held_ >= kTaps;
}

void SoundVoice::add_to(std::span<float> mix, double step) noexcept {
  const auto frames = static_cast<std::int64_t>(mix.size() / channels_);
  for (std::int64_t i = 0; i < frames && source_; ++i) {
    const std::int64_t most = std::min(kRoom, frames - i + kTaps + 8);
    if (have(frame_ - kBefore, most)) {
      arrived_ = true;
      rise_ = std::min(1.0, rise_ + ramp_);
      const auto gain = static_cast<float>(rise_ * fall_);
      resampler_->between({window_.data() + (frame_ - kBefore - base_) * static_cast<std::int64_t>(channels_),
                           static_cast<std::size_t>(kTaps) * channels_},
                          fraction_, out_);
      for (std::size_t c = 0; c < channels_; ++c)
        mix[static_cast<std::size_t>(i) * channels_ + c] += gain * out_[c];
    } else {
      rise_ = 0.0;
      missing_ += arrived_ ? 1 : 0;
    }
    fraction_ += step;
    const auto whole = static_cast<std::int64_t>(std::floor(fraction_));
    frame_ += whole;
    fraction_ -= static_cast<double>(whole);
    fall_ -= fall_step_;
    if (fall_ <= 0.0) source_ = nullptr;
  }
}

}  // namespace cupola
