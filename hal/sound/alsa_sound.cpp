// One PCM, never waited for: what it has no room for is offered again.
// SPDX-License-Identifier: MIT
#include "hal/sound/alsa_sound.h"

#include <alsa/asoundlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <vector>

namespace cupola {
namespace {

constexpr unsigned kBuffer = 200'000;  // microseconds
constexpr unsigned kPeriod = 10'000;
constexpr std::int64_t kBlock = 512;  // frames converted at a time
constexpr std::array<snd_pcm_format_t, 3> kFormats = {SND_PCM_FORMAT_FLOAT, SND_PCM_FORMAT_S32,
                                                      SND_PCM_FORMAT_S16};

void be_silent(const char* /*file*/, int /*line*/, const char* /*function*/, int /*error*/,
               const char* /*format*/, ...) {}

struct Close {
  void operator()(snd_pcm_t* pcm) const { snd_pcm_close(pcm); }
};

// 5.1 and 7.1 are front, back, centre, low, side to ALSA where it has no map of its own.
int place_of(int channel, int channels) {
  constexpr std::array<int, 8> kPlaces = {0, 1, 4, 5, 2, 3, 6, 7};
  return channels == 6 || channels == 8 ? kPlaces[static_cast<std::size_t>(channel)] : channel;
}

class AlsaSound final : public SoundOutput {
 public:
  AlsaSound(std::string device, Clock& clock) : device_(std::move(device)), clock_(clock) {
    snd_lib_error_set_handler(be_silent);  // what is wrong is in our own words
  }

  std::optional<SoundMode> open(const SoundMode& wanted) noexcept override;
  std::optional<std::int64_t> write(std::span<const float> samples) noexcept override;
  std::optional<SoundHeard> heard() noexcept override;
  const char* trouble() const noexcept override { return trouble_.data(); }

 private:
  bool set_up(const SoundMode& wanted) noexcept;
  // The same stream again after an underrun or a suspend; false when it is lost.
  bool recover(snd_pcm_sframes_t error) noexcept;
  void lose(const char* what, snd_pcm_sframes_t error) noexcept;
  const void* converted(std::span<const float> samples) noexcept;

  std::string device_;
  Clock& clock_;
  std::unique_ptr<snd_pcm_t, Close> pcm_;
  snd_pcm_format_t format_ = SND_PCM_FORMAT_FLOAT;
  SoundMode mode_;
  bool begun_ = false;     // something was written since it was prepared
  std::int64_t room_ = 0;  // of its buffer, frames
  std::int64_t written_ = 0;
  std::int64_t underruns_ = 0;
  std::vector<std::int32_t> words_;  // a block in the device's format
  std::array<char, 200> trouble_{};
};

void AlsaSound::lose(const char* what, snd_pcm_sframes_t error) noexcept {
  std::snprintf(trouble_.data(), trouble_.size(), "%s: %s: %s", device_.c_str(), what,
                snd_strerror(static_cast<int>(error)));
  pcm_.reset();
}

bool AlsaSound::set_up(const SoundMode& wanted) noexcept {
  snd_pcm_hw_params_t* hardware = nullptr;
  snd_pcm_hw_params_alloca(&hardware);
  snd_pcm_t* pcm = pcm_.get();
  const auto refused = [&](const char* what, int error) {
    if (error >= 0) return false;
    lose(what, error);
    return true;
  };
  if (refused("it has no modes", snd_pcm_hw_params_any(pcm, hardware))) return false;
  // Its own rate, where the plugins know it: ours is the better resampler.
  snd_pcm_hw_params_set_rate_resample(pcm, hardware, 0);
  if (refused("samples are not taken in turn",
              snd_pcm_hw_params_set_access(pcm, hardware, SND_PCM_ACCESS_RW_INTERLEAVED)))
    return false;
  int error = -EINVAL;
  for (const snd_pcm_format_t format : kFormats) {
    error = snd_pcm_hw_params_set_format(pcm, hardware, format);
    if (error < 0) continue;
    format_ = format;
    break;
  }
  if (refused("takes neither floats nor 32 or 16 bits", error)) return false;
  auto channels = static_cast<unsigned>(wanted.channels);
  auto rate = static_cast<unsigned>(wanted.rate);
  unsigned buffer = kBuffer;
  unsigned period = kPeriod;
  if (refused("channels", snd_pcm_hw_params_set_channels_near(pcm, hardware, &channels)) ||
      refused("rate", snd_pcm_hw_params_set_rate_near(pcm, hardware, &rate, nullptr)))
    return false;
  snd_pcm_hw_params_set_buffer_time_near(pcm, hardware, &buffer, nullptr);
  snd_pcm_hw_params_set_period_time_near(pcm, hardware, &period, nullptr);
  if (refused("cannot be set up", snd_pcm_hw_params(pcm, hardware))) return false;
  snd_pcm_sw_params_t* software = nullptr;
  snd_pcm_sw_params_alloca(&software);
  if (refused("cannot be set up", snd_pcm_sw_params_current(pcm, software)) ||
      refused("cannot be set up", snd_pcm_sw_params_set_start_threshold(pcm, software, 1)) ||
      refused("cannot be set up", snd_pcm_sw_params(pcm, software)))
    return false;
  snd_pcm_uframes_t room = 0;
  if (refused("cannot be set up", snd_pcm_hw_params_get_buffer_size(hardware, &room))) return false;
  room_ = static_cast<std::int64_t>(room);
  mode_ = {static_cast<int>(rate), static_cast<int>(channels)};
  return true;
}

std::optional<SoundMode> AlsaSound::open(const SoundMode& wanted) noexcept {
  pcm_.reset();
  written_ = 0;
  underruns_ = 0;
  begun_ = false;
  snd_pcm_t* pcm = nullptr;
  if (const int error = snd_pcm_open(&pcm, device_.c_str(), SND_PCM_STREAM_PLAYBACK, SND_PCM_NONBLOCK);
      error < 0) {
    lose("cannot be opened", error);
    return std::nullopt;
  }
  pcm_.reset(pcm);
  if (!set_up(wanted)) return std::nullopt;
  words_.resize(static_cast<std::size_t>(kBlock * mode_.channels));
  return mode_;
}

bool AlsaSound::recover(snd_pcm_sframes_t error) noexcept {
  if (error == -EPIPE || error == -ESTRPIPE) {
    if (begun_) ++underruns_;
    begun_ = false;
    error = snd_pcm_prepare(pcm_.get());
    if (error >= 0) return true;
  }
  lose("is lost", error);
  return false;
}

// At most kBlock frames. Samples beyond 1 are cut.
const void* AlsaSound::converted(std::span<const float> samples) noexcept {
  auto* bytes = reinterpret_cast<std::byte*>(words_.data());
  const int channels = mode_.channels;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const int channel = static_cast<int>(i) % channels;
    const std::size_t to =
        i - static_cast<std::size_t>(channel) + static_cast<std::size_t>(place_of(channel, channels));
    const double sample = std::clamp(static_cast<double>(samples[i]), -1.0, 1.0);
    if (format_ == SND_PCM_FORMAT_FLOAT) {
      reinterpret_cast<float*>(bytes)[to] = static_cast<float>(sample);
    } else if (format_ == SND_PCM_FORMAT_S32) {
      words_[to] = static_cast<std::int32_t>(std::lround(sample * 2147483647.0));
    } else {
      reinterpret_cast<std::int16_t*>(bytes)[to] = static_cast<std::int16_t>(std::lround(sample * 32767.0));
    }
  }
  return bytes;
}

std::optional<std::int64_t> AlsaSound::write(std::span<const float> samples) noexcept {
  if (!pcm_) return std::nullopt;
  const auto frames = static_cast<std::int64_t>(samples.size()) / mode_.channels;
  std::int64_t taken = 0;
  bool recovered = false;
  while (taken < frames) {
    const std::int64_t block = std::min(kBlock, frames - taken);
    const auto part = samples.subspan(static_cast<std::size_t>(taken * mode_.channels),
                                      static_cast<std::size_t>(block * mode_.channels));
    const snd_pcm_sframes_t wrote =
        snd_pcm_writei(pcm_.get(), converted(part), static_cast<snd_pcm_uframes_t>(block));
    if (wrote == -EAGAIN || wrote == 0) break;
    if (wrote < 0) {
      if (recovered || !recover(wrote)) {
        if (pcm_) lose("is lost", wrote);
        return std::nullopt;
      }
      recovered = true;
      continue;
    }
    begun_ = true;
    taken += wrote;
    written_ += wrote;
  }
  return taken;
}

std::optional<SoundHeard> AlsaSound::heard() noexcept {
  if (!pcm_) return std::nullopt;
  snd_pcm_sframes_t free = room_;
  snd_pcm_sframes_t delay = 0;
  if (begun_) {
    if (const int error = snd_pcm_avail_delay(pcm_.get(), &free, &delay); error < 0) {
      if (!recover(error)) return std::nullopt;
      free = room_;
      delay = 0;
    }
  }
  // Devices may say that they hold more than they were given.
  return SoundHeard{std::clamp<std::int64_t>(written_ - delay, 0, written_), clock_.now(),
                    std::clamp<std::int64_t>(room_ - free, 0, room_), underruns_};
}

}  // namespace

std::unique_ptr<SoundOutput> make_alsa_sound(const std::string& device, Clock& clock) {
  return std::make_unique<AlsaSound>(device, clock);
}

}  // namespace cupola
