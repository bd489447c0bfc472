// From the show file's names to queues of samples.
// SPDX-License-Identifier: MIT
#include "firmware/open_sound.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/sound/alsa_sound.h"
#include "pipeline/frame/error.h"
#include "pipeline/source/numbered_files.h"

namespace cupola {

namespace {

constexpr int kUsualRate = 48000;
constexpr int kAheadSeconds = 2;

}  // namespace

std::string sound_file(const Cue& cue, const Rig& rig) {
  if (cue.sound != kOwnSound) return cue.sound;
  if (!has_view(cue.file)) return cue.file;
  std::vector<std::string> views;
  for (const View& view : rig.views) views.push_back(view.name);
  return files_of_views(cue.file, views).front().string();
}

std::unique_ptr<SoundTrack> open_cue_sound(const Cue& cue, const Rig& rig, int rate, int channels) {
  return open_sound(sound_file(cue, rig), rate, channels);
}

SoundPart sound_part(const Cue& cue, const CueTiming& timing, const SoundTrack& track, int rate) {
  SoundPart part;
  part.loop = timing.loop;
  if (cue.sound == kOwnSound) {
    const auto frames = [&](std::int64_t pictures) {
      return std::llround(static_cast<double>(pictures) / timing.rate * rate);
    };
    part.first = frames(timing.first);
    if (timing.frames) part.length = std::max<std::int64_t>(1, frames(*timing.frames));
  } else if (track.length() > 0) {
    part.length = track.length();
  }
  return part;
}

SoundThread::SoundThread(const Show& show, const Timeline& timeline, Clock& clock, ControlLink& link)
    : clock_(clock), output_(make_alsa_sound(show.sound.device, clock)) {
  if (!output_) {
    link.log.warn(Topic::kSound, "this program was built without sound; the show is silent");
    return;
  }
  // First the files, for the number of channels; then the device; then the files again as it wants them.
  SoundMode mode{kUsualRate, show.sound.channels};
  std::vector<bool> there(show.cues.size());
  int most = 0;
  for (std::size_t i = 0; i < show.cues.size(); ++i) {
    const Cue& cue = show.cues[i];
    if (cue.sound.empty()) continue;
    try {
      most = std::max(most, open_cue_sound(cue, show.rig, kUsualRate, 0)->file_channels());
      there[i] = true;
    } catch (const InputError& error) {
      link.log.warn(Topic::kSound, fmt::format("cue {}: {}; it is silent", cue.name, error.what()));
    }
  }
  if (mode.channels == 0) mode.channels = most == 0 ? 2 : std::max(most, 2);
  const std::optional<SoundMode> got = output_->open(mode);
  if (got) mode = *got;
  std::vector<CueSound> sounds(show.cues.size());
  for (std::size_t i = 0; i < show.cues.size(); ++i) {
    const Cue& cue = show.cues[i];
    sounds[i].cue = cue.name;
    sounds[i].fade = std::chrono::nanoseconds(std::llround(cue.fade_s * 1e9));
    if (!there[i]) continue;
    try {
      std::unique_ptr<SoundTrack> track = open_cue_sound(cue, show.rig, mode.rate, mode.channels);
      if (track->length() > 0) sounds[i].length = track->length();
      const SoundPart part = sound_part(cue, timeline.timing(i), *track, mode.rate);
      sounds[i].ahead = std::make_unique<SoundAhead>(std::move(track), mode.channels, part,
                                                     std::int64_t{kAheadSeconds} * mode.rate, false);
    } catch (const InputError& error) {
      link.log.warn(Topic::kSound, fmt::format("cue {}: {}; it is silent", cue.name, error.what()));
    }
  }
  sound_ = std::make_unique<ShowSound>(show.sound, std::move(sounds), timeline, *output_, mode,
                                       got.has_value(), clock, link);
  thread_ = std::thread([this] {
    while (!stopping_) {
      sound_->step();
      clock_.sleep_until(clock_.now() + ShowSound::kTurn);
    }
  });
}

SoundThread::~SoundThread() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

}  // namespace cupola
