// One cue's sound on its way into the mix: at any place, a little faster or slower, without clicks.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/sound/fine_resampler.h"
#include "pipeline/sound/sound_ahead.h"

namespace cupola {

class SoundVoice {
 public:
  // `resampler` is borrowed. A voice has nothing to say until begin().
  SoundVoice(const FineResampler& resampler, int channels, std::int64_t ramp_frames);

  // From frame `place` of `source`, borrowed, on; within the ramp's frames from silence to full.
  void begin(SoundAhead& source, std::int64_t place) noexcept;
  // To silence within so many frames.
  void end(std::int64_t frames) noexcept;
  void be_silent() noexcept { source_ = nullptr; }
  bool sounds() const noexcept { return source_ != nullptr; }
  bool reads(const SoundAhead& source) const noexcept { return source_ == &source; }

  // Adds the frames that come to `mix`, each `step` frames of the source after the one before. What is not
  // decoded in time is silence; the place moves on all the same.
  void add_to(std::span<float> mix, double step) noexcept;

  double place() const noexcept { return static_cast<double>(frame_) + fraction_; }
  std::int64_t missing() const noexcept { return missing_; }  // frames that were not decoded in time, ever

 private:
  bool have(std::int64_t first, std::int64_t most) noexcept;

  const FineResampler* resampler_;
  std::size_t channels_;
  double ramp_;
  SoundAhead* source_ = nullptr;
  std::int64_t frame_ = 0;  // the place of the next frame
  double fraction_ = 0.0;
  double rise_ = 0.0;  // the ramp at its begin
  double fall_ = 1.0;  // and at its end
  double fall_step_ = 0.0;
  std::int64_t missing_ = 0;
  bool arrived_ = false;       // since begin()
  std::vector<float> window_;  // the source's frames [base_, base_ + held_)
  std::int64_t base_ = 0;
  std::int64_t held_ = 0;
  std::vector<float> out_;  // one frame
};

}  // namespace cupola
