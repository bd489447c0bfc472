// The sound of a show, kept in step with its pictures: step by step, on a thread of its own or a test's.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "firmware/control_link.h"
#include "firmware/sound_set.h"
#include "firmware/sound_settings.h"
#include "firmware/sound_voice.h"
#include "hal/sound/sound_clock.h"
#include "hal/sound/sound_output.h"
#include "hal/time/clock.h"

namespace cupola {

// The device plays from begin to end, silence too. Each step hands it so much that kLead lies before it, and
// computes from its position when the next frame will be heard, from the loop's status where the show will
// stand then, and so which frame of which sound that has to be. What is a little off is played faster or
// slower; what is far off, jumps. As master the sound plays as it is, and the loop is told to follow.
// When the loop plays a show that was read again, that one's set takes the place of the old one.
class ShowSound {
 public:
  static constexpr std::chrono::nanoseconds kLead = std::chrono::milliseconds(60);
  static constexpr std::chrono::nanoseconds kTurn = std::chrono::milliseconds(10);  // from step to step

  // `set`: for `mode`, which `output` was opened at if `opened`; later ones come from `link`'s ShowReload.
  // `output`, `clock` and `link` are borrowed.
  ShowSound(const SoundSettings& settings, std::unique_ptr<SoundSet> set, SoundOutput& output,
            const SoundMode& mode, bool opened, Clock& clock, ControlLink& link);

  // Bounded, but for opening a device that came back. One thread.
  void step() noexcept;

  SoundReport report() const { return report_; }

 private:
  struct Target {
    std::size_t cue = 0;
    double frame = 0.0;  // of its sound, if it has one
  };
  // What ought to be heard at `when`; none: nothing, as the show stands or is over.
  std::optional<Target> target_at(std::chrono::nanoseconds when) const noexcept;
  std::chrono::nanoseconds time_of(std::int64_t frame) const noexcept;

  bool be_open(std::chrono::nanoseconds now) noexcept;
  void lose(std::chrono::nanoseconds now) noexcept;
  void restart() noexcept;
  void change_set() noexcept;
  void rest_unheard() noexcept;
  void make(std::int64_t frames) noexcept;
  // Which voice is to say what in the block that comes.
  void conduct(std::chrono::nanoseconds when) noexcept;
  void hush(std::chrono::nanoseconds fade) noexcept;
  void leave(SoundVoice& voice) noexcept;
  void jump(const Target& target) noexcept;
  void steer(double early_s) noexcept;
  void write() noexcept;
  void note_drift(std::chrono::nanoseconds now) noexcept;
  void note_end() noexcept;

  const bool master_;
  std::unique_ptr<SoundSet> set_;
  std::unique_ptr<SoundSet> next_;  // of a show that the loop does not play yet; null: none
  SoundOutput& output_;
  const SoundMode mode_;
  Clock& clock_;
  ControlLink& link_;
  const FineResampler resampler_;
  const std::int64_t ramp_frames_;

  PlayerStatus status_;  // the loop's last
  bool open_ = false;
  bool said_away_ = false;
  std::chrono::nanoseconds next_try_{0};
  SoundClock heard_;
  SoundHeard last_;                    // what the device said last
  std::chrono::nanoseconds begun_{0};  // of the clock: when the stream did
  std::int64_t stream_begin_ = 0;      // its first frame
  std::int64_t sent_ = 0;              // frames that it took since it was opened
  std::int64_t made_ = 0;              // the same and pending_
  std::vector<float> pending_;
  std::vector<float> block_;

  SoundVoice voice_;                // of the cue that plays
  SoundVoice old_;                  // of the one before, falling silent
  std::optional<std::size_t> cue_;  // whose sound voice_ is
  std::int64_t voice_begin_ = 0;    // the frame of the stream at which it began
  bool out_of_step_ = false;        // after an underrun: begin anew where the show is
  double step_ = 1.0;
  std::vector<float> tail_;  // what is still to be heard of a place that was left by a jump
  std::size_t tail_used_ = 0;
  double gain_ = 1.0;
  std::int64_t damaged_before_ = 0;  // in sets that are gone
  SoundReport report_;
};

}  // namespace cupola
