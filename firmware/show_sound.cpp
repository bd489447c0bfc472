// One device, one voice and what is left of the one before.
// SPDX-License-Identifier: MIT
#include "firmware/show_sound.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

namespace cupola {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

namespace {

constexpr nanoseconds kRamp = 5ms;
constexpr nanoseconds kRetry = 1s;  // between two attempts to open a device that is away
constexpr std::int64_t kBlock = 480;
constexpr double kMostOff = 0.04;          // seconds: more is not made up for but jumped
constexpr double kMostFaster = 0.003;      // five cents: inaudible
constexpr double kMostPace = 0.005;        // of pictures: nobody sees a frame of 200 more or less
constexpr double kMakeUp = 5.0;            // seconds: what is off falls to 1/e within them
constexpr double kLoudening = 1.0 / 0.05;  // a second: the whole range in 50 ms
// Plugins without a clock take all they are given: they get it hardly faster than it would be heard.
constexpr double kMostHaste = 1.005;

double seconds(nanoseconds time) {
  return static_cast<double>(time.count()) * 1e-9;
}

std::int64_t frames_in(nanoseconds time, int rate) {
  return std::llround(seconds(time) * rate);
}

// Loudness is felt by powers: as PulseAudio's and PipeWire's sliders, 50 % are -18 dB.
double gain_of(int volume) {
  const double part = 0.01 * volume;
  return part * part * part;
}

}  // namespace

ShowSound::ShowSound(const SoundSettings& settings, std::unique_ptr<SoundSet> set, SoundOutput& output,
                     const SoundMode& mode, bool opened, Clock& clock, ControlLink& link)
    : master_(settings.master),
      set_(std::move(set)),
      output_(output),
      mode_(mode),
      clock_(clock),
      link_(link),
      ramp_frames_(frames_in(kRamp, mode.rate)),
      open_(opened),
      next_try_(clock.now()),
      heard_(mode.rate),
      begun_(clock.now()),
      block_(static_cast<std::size_t>(kBlock * mode.channels)),
      voice_(resampler_, mode.channels, ramp_frames_),
      old_(resampler_, mode.channels, ramp_frames_),
      gain_(gain_of(settings.volume)) {
  pending_.reserve(static_cast<std::size_t>(mode.rate) * static_cast<std::size_t>(mode.channels));
  tail_.reserve(static_cast<std::size_t>(ramp_frames_ * mode.channels));
  status_.volume = settings.volume;
  report_.wanted = true;
  report_.master = settings.master;
  report_.rate = mode.rate;
  report_.channels = mode.channels;
}

bool ShowSound::be_open(nanoseconds now) noexcept {
  if (open_) return true;
  if (now < next_try_) return false;
  const std::optional<SoundMode> got = output_.open(mode_);
  if (got == mode_) {
    open_ = true;
    sent_ = 0;
    last_ = {};
    last_.at = clock_.now();
    restart();
    if (said_away_) link_.log.notice(Topic::kSound, "the sound device is back");
    said_away_ = false;
    report_.trouble = {};
    return true;
  }
  if (got) {
    std::snprintf(report_.trouble.data(), report_.trouble.size(),
                  "it has %d channels at %d Hz now, not %d at %d", got->channels, got->rate, mode_.channels,
                  mode_.rate);
  } else {
    std::snprintf(report_.trouble.data(), report_.trouble.size(), "%s", output_.trouble());
  }
  lose(now);
  return false;
}

void ShowSound::lose(nanoseconds now) noexcept {
  if (open_) ++report_.losses;
  open_ = false;
  next_try_ = now + kRetry;
  voice_.be_silent();
  old_.be_silent();
  cue_.reset();
  if (said_away_) return;
  said_away_ = true;
  std::array<char, EventLog::kLongest> words{};
  std::snprintf(words.data(), words.size(), "the sound device is away: %s", report_.trouble.data());
  link_.log.warn(Topic::kSound, words.data());
}

// The stream goes on after silence.
void ShowSound::restart() noexcept {
  pending_.clear();
  made_ = sent_;
  stream_begin_ = last_.frames;
  begun_ = clock_.now();
  heard_.begin_anew();
  out_of_step_ = true;
}

nanoseconds ShowSound::time_of(std::int64_t frame) const noexcept {
  if (heard_.knows()) return heard_.time_of(static_cast<double>(frame));
  const double ahead = static_cast<double>(frame - last_.frames) / mode_.rate;
  return last_.at + nanoseconds(std::llround(1e9 * ahead));
}

std::optional<ShowSound::Target> ShowSound::target_at(nanoseconds when) const noexcept {
  if (status_.state != PlayerState::kPlaying || status_.show_number != set_->show) return std::nullopt;
  const auto place =
      set_->timeline.ahead({status_.show.cue, status_.show.position}, when - set_->delay - status_.due);
  if (!place) return std::nullopt;
  return Target{place->cue, seconds(place->position) * mode_.rate};
}

void ShowSound::step() noexcept {
  const nanoseconds now = clock_.now();
  status_ = link_.status.read();
  change_set();
  if (be_open(now)) {
    const std::optional<SoundHeard> heard = output_.heard();
    if (!heard) {
      std::snprintf(report_.trouble.data(), report_.trouble.size(), "%s", output_.trouble());
      lose(now);
    } else {
      if (heard->underruns != last_.underruns) {
        report_.underruns += heard->underruns - last_.underruns;
        last_ = *heard;
        restart();
      }
      last_ = *heard;
      if (last_.frames > stream_begin_) heard_.note(last_.frames, last_.at);
      const std::int64_t lead = frames_in(kLead, mode_.rate);
      const auto paced = static_cast<std::int64_t>(seconds(now - begun_) * mode_.rate * kMostHaste) + lead;
      std::int64_t room = std::min(lead - last_.queued - (made_ - sent_), paced - (made_ - stream_begin_));
      for (; room > 0 && open_; room -= kBlock) make(std::min(room, kBlock));
      if (open_) note_drift(now);
    }
  }
  report_.working = open_;
  report_.sounding = open_ && voice_.sounds();
  report_.device_ppm = heard_.ppm();
  report_.missing = voice_.missing() + old_.missing();
  report_.damaged = damaged_before_;
  for (const CueSound& sound : set_->sounds) report_.damaged += sound.ahead ? sound.ahead->damaged() : 0;
  note_end();
  rest_unheard();
  if (!open_ && master_) link_.pace_ppb = 0;  // nothing to follow
  link_.sound.publish(report_);
}

// A set is there before the loop has its show, and is waited for by nobody: where the loop is further than
// that, target_at() says nothing.
void ShowSound::change_set() noexcept {
  if (!next_ && link_.reload) next_ = link_.reload->take_sounds();
  if (!next_ || next_->show != status_.show_number) return;
  leave(voice_);
  leave(old_);
  cue_.reset();
  damaged_before_ = report_.damaged;
  set_.swap(next_);
  link_.reload->sounds_left(std::move(next_));
}

// Silent after a ramp, which is made now: from here on the voice's source may be another's, or gone.
void ShowSound::leave(SoundVoice& voice) noexcept {
  if (!voice.sounds()) return;
  tail_.erase(tail_.begin(), tail_.begin() + static_cast<std::ptrdiff_t>(tail_used_));
  tail_.resize(static_cast<std::size_t>(ramp_frames_ * mode_.channels), 0.0F);
  tail_used_ = 0;
  voice.end(ramp_frames_);
  voice.add_to(tail_, step_);
  voice.be_silent();
}

// The voice that plays falls silent.
void ShowSound::hush(nanoseconds fade) noexcept {
  if (!voice_.sounds()) return;
  leave(old_);  // no room for three
  std::swap(voice_, old_);
  old_.end(std::max(frames_in(fade, mode_.rate), ramp_frames_));
  voice_.be_silent();
}

void ShowSound::jump(const Target& target) noexcept {
  CueSound& sound = set_->sounds[target.cue];
  SoundAhead& source = *sound.ahead;
  // Nobody else may read it meanwhile.
  if (cue_ == target.cue) leave(voice_);
  if (old_.reads(source)) leave(old_);
  voice_.begin(source, std::llround(target.frame));
  cue_ = target.cue;
  sound.heard = true;
  voice_begin_ = made_;
  step_ = 1.0;
}

void ShowSound::steer(double early_s) noexcept {
  const double faster = 1e-6 * heard_.ppm();
  if (master_) {
    const double pace = std::clamp(faster + early_s / kMakeUp, -kMostPace, kMostPace);
    link_.pace_ppb = std::llround(1e9 * pace);
    report_.applied_ppm = 1e6 * pace;
    step_ = 1.0;
  } else {
    step_ = std::clamp(1.0 / (1.0 + faster) - early_s / kMakeUp, 1.0 - kMostFaster, 1.0 + kMostFaster);
    report_.applied_ppm = 1e6 * (step_ - 1.0);
  }
}

void ShowSound::conduct(nanoseconds when) noexcept {
  const std::optional<Target> target = target_at(when);
  if (!target || !set_->sounds[target->cue].ahead) {
    hush(target ? set_->sounds[target->cue].fade : kRamp);
    cue_.reset();
    if (master_) steer(0.0);
    return;
  }
  if (cue_ != target->cue) {
    hush(set_->sounds[target->cue].fade);
    jump(*target);
    out_of_step_ = false;
  }
  const double early_s = (voice_.place() - target->frame) / mode_.rate;
  if (out_of_step_ || std::abs(early_s) > kMostOff) {
    jump(*target);
    out_of_step_ = false;
    return steer(0.0);
  }
  steer(early_s);
}

void ShowSound::make(std::int64_t frames) noexcept {
  if (!pending_.empty()) {
    write();
    if (!pending_.empty()) return;  // the device has no room for what there is
  }
  conduct(time_of(made_));
  const auto channels = static_cast<std::size_t>(mode_.channels);
  const std::span<float> block(block_.data(), static_cast<std::size_t>(frames) * channels);
  std::ranges::fill(block, 0.0F);
  voice_.add_to(block, step_);
  old_.add_to(block, step_);
  for (std::size_t i = 0; i < block.size() && tail_used_ < tail_.size(); ++i) block[i] += tail_[tail_used_++];
  const double gain = gain_of(status_.volume);
  const double louder = kLoudening / mode_.rate;
  for (std::size_t i = 0; i < block.size(); i += channels) {
    gain_ = std::clamp(gain, gain_ - louder, gain_ + louder);
    for (std::size_t c = 0; c < channels; ++c) block[i + c] *= static_cast<float>(gain_);
  }
  pending_.assign(block.begin(), block.end());
  made_ += frames;
  write();
}

void ShowSound::write() noexcept {
  while (!pending_.empty()) {
    const std::optional<std::int64_t> taken = output_.write(pending_);
    if (!taken) {
      std::snprintf(report_.trouble.data(), report_.trouble.size(), "%s", output_.trouble());
      return lose(clock_.now());
    }
    if (*taken == 0) return;
    sent_ += *taken;
    pending_.erase(pending_.begin(), pending_.begin() + *taken * mode_.channels);
  }
}

// Cues that the show has left begin at their begin when it comes back.
void ShowSound::rest_unheard() noexcept {
  for (std::size_t cue = 0; cue < set_->sounds.size(); ++cue) {
    CueSound& sound = set_->sounds[cue];
    if (!sound.heard || cue == status_.show.cue || cue_ == cue) continue;
    if (voice_.reads(*sound.ahead) || old_.reads(*sound.ahead)) continue;
    sound.ahead->rest();
    sound.heard = false;
  }
}

void ShowSound::note_drift(nanoseconds now) noexcept {
  if (!voice_.sounds() || !cue_ || !heard_.knows()) {
    report_.drift = 0ns;
    return;
  }
  const double heard = heard_.heard_at(now);
  const std::optional<Target> target = target_at(now);
  if (!target || target->cue != *cue_ || heard < static_cast<double>(voice_begin_)) return;  // not yet
  const double place = voice_.place() - (static_cast<double>(made_) - heard) * step_;
  report_.drift = nanoseconds(std::llround(1e9 * (place - target->frame) / mode_.rate));
}

// Once a cue: its file is shorter than it said.
void ShowSound::note_end() noexcept {
  if (!cue_ || set_->sounds[*cue_].end_said) return;
  CueSound& sound = set_->sounds[*cue_];
  const std::optional<std::int64_t> ended = sound.ahead->ended();
  if (!ended) return;
  sound.end_said = true;
  const std::string trouble = sound.ahead->trouble();
  if (!trouble.empty()) {
    link_.log.warn(Topic::kSound, fmt::format("cue {}: {}; it is silent from there on", sound.cue, trouble));
  } else if (sound.length && *ended < *sound.length - mode_.rate / 10) {
    link_.log.warn(Topic::kSound,
                   fmt::format("cue {}: {}: ends after {:.1f} of {:.1f} s; the rest is silent", sound.cue,
                               sound.ahead->name(), static_cast<double>(*ended) / mode_.rate,
                               static_cast<double>(*sound.length) / mode_.rate));
  }
}

}  // namespace cupola
