// A ring that empties by the clock.
// SPDX-License-Identifier: MIT
#include "hal/sound/fake_sound.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cupola {

using std::chrono::nanoseconds;

FakeSound::FakeSound(Clock& clock, const SoundMode& mode, FakeSoundFaults faults)
    : clock_(clock),
      mode_(mode),
      faults_(std::move(faults)),
      room_(mode.rate / 5),
      memory_(static_cast<std::size_t>(room_ * mode.channels)) {}

bool FakeSound::away() noexcept {
  const auto& absences = faults_.absences;
  const nanoseconds now = clock_.now();
  while (next_absence_ < absences.size() && absences[next_absence_].until <= now) ++next_absence_;
  const bool away = next_absence_ < absences.size() && absences[next_absence_].from <= now;
  if (away) {
    open_ = false;
    trouble_ = "unplugged on demand";
  }
  return away;
}

std::optional<SoundMode> FakeSound::open(const SoundMode& /*wanted*/) noexcept {
  if (away()) return std::nullopt;
  ++opens_;
  open_ = true;
  running_ = false;
  written_ = 0;
  played_ = 0.0;
  underruns_ = 0;
  return mode_;
}

void FakeSound::play_on() noexcept {
  const nanoseconds now = clock_.now();
  const double seconds = static_cast<double>((now - played_at_).count()) * 1e-9;
  played_at_ = now;
  if (running_) played_ += seconds * mode_.rate * (1.0 + 1e-6 * faults_.ppm);
  bool starved = played_ >= static_cast<double>(written_);
  while (next_underrun_ < faults_.underruns.size() && faults_.underruns[next_underrun_] <= now) {
    ++next_underrun_;
    starved = true;
  }
  if (running_ && starved) {
    played_ = static_cast<double>(written_);
    running_ = false;
    ++underruns_;
  }
}

std::optional<std::int64_t> FakeSound::write(std::span<const float> samples) noexcept {
  if (away() || !open_) return std::nullopt;
  play_on();
  const auto wanted = static_cast<std::int64_t>(samples.size()) / mode_.channels;
  const std::int64_t taken = std::min({wanted, faults_.most_a_write, room_ - buffered()});
  for (std::int64_t i = 0; i < taken * mode_.channels; ++i) {
    memory_[static_cast<std::size_t>((written_ * mode_.channels + i) % (room_ * mode_.channels))] =
        samples[static_cast<std::size_t>(i)];
  }
  written_ += taken;
  running_ = running_ || taken > 0;
  return taken;
}

std::optional<SoundHeard> FakeSound::heard() noexcept {
  if (away() || !open_) return std::nullopt;
  play_on();
  chance_ ^= chance_ << 13;
  chance_ ^= chance_ >> 7;
  chance_ ^= chance_ << 17;
  const double wrong = (static_cast<double>(chance_ >> 11) * 0x1p-52 - 1.0) *
                       static_cast<double>(faults_.jitter.count()) * 1e-9 * mode_.rate;
  const double late = static_cast<double>(faults_.latency.count()) * 1e-9 * mode_.rate;
  const auto frames = static_cast<std::int64_t>(std::floor(played_ - late + (running_ ? wrong : 0.0)));
  return SoundHeard{std::clamp<std::int64_t>(frames / faults_.grain * faults_.grain, 0, written_),
                    clock_.now(), buffered(), underruns_};
}

std::int64_t FakeSound::buffered() noexcept {
  play_on();
  return written_ - static_cast<std::int64_t>(played_);
}

float FakeSound::sounding(int channel) noexcept {
  play_on();
  if (!running_) return 0.0F;
  const double late = static_cast<double>(faults_.latency.count()) * 1e-9 * mode_.rate;
  const auto frame = static_cast<std::int64_t>(played_ - late);
  if (frame < std::max<std::int64_t>(0, written_ - room_)) return 0.0F;
  return memory_[static_cast<std::size_t>((frame * mode_.channels + channel) % (room_ * mode_.channels))];
}

}  // namespace cupola
