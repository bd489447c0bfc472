// From the show file's names to queues of samples.
// SPDX-License-Identifier: MIT
#include "firmware/open_sound.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

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

namespace {

// But for its sound.
SoundSet silent_set(const Show& show, const Timeline& timeline) {
  SoundSet set{{}, timeline, show.sound.delay};
  for (const Cue& cue : show.cues)
    set.sounds.push_back(
        {.cue = cue.name, .ahead = {}, .fade = std::chrono::nanoseconds(std::llround(cue.fade_s * 1e9))});
  return set;
}

// Begins its decoder's thread; throws InputError.
void open_into(SoundSet& set, std::size_t i, const Show& show, const SoundMode& mode) {
  const Cue& cue = show.cues[i];
  std::unique_ptr<SoundTrack> track = open_cue_sound(cue, show.rig, mode.rate, mode.channels);
  if (track->length() > 0) set.sounds[i].length = track->length();
  const SoundPart part = sound_part(cue, set.timeline.timing(i), *track, mode.rate);
  set.sounds[i].ahead = std::make_unique<SoundAhead>(std::move(track), mode.channels, part,
                                                     std::int64_t{kAheadSeconds} * mode.rate, false);
}

}  // namespace

std::unique_ptr<SoundSet> open_sounds(const Show& show, const Timeline& timeline, const SoundMode& mode) {
  auto set = std::make_unique<SoundSet>(silent_set(show, timeline));
  for (std::size_t i = 0; i < show.cues.size(); ++i) {
    if (show.cues[i].sound.empty()) continue;
    try {
      open_into(*set, i, show, mode);
    } catch (const InputError& error) {
      throw InputError(fmt::format("cue {}: {}", show.cues[i].name, error.what()));
    }
  }
  return set;
}

std::optional<OpenSound> open_sound_device(const Show& show, const Timeline& timeline, Clock& clock,
                                           EventLog& log) {
  OpenSound sound{make_alsa_sound(show.sound.device, clock), {kUsualRate, show.sound.channels}, false, {}};
  if (!sound.output) {
    log.warn(Topic::kSound, "this program was built without sound; the show is silent");
    return std::nullopt;
  }
  // First the files, for the number of channels; then the device; then the files again as it wants them.
  std::vector<bool> there(show.cues.size());
  int most = 0;
  for (std::size_t i = 0; i < show.cues.size(); ++i) {
    const Cue& cue = show.cues[i];
    if (cue.sound.empty()) continue;
    try {
      most = std::max(most, open_cue_sound(cue, show.rig, kUsualRate, 0)->file_channels());
      there[i] = true;
    } catch (const InputError& error) {
      log.warn(Topic::kSound, fmt::format("cue {}: {}; it is silent", cue.name, error.what()));
    }
  }
  if (sound.mode.channels == 0) sound.mode.channels = most == 0 ? 2 : std::max(most, 2);
  const std::optional<SoundMode> got = sound.output->open(sound.mode);
  sound.opened = got.has_value();
  if (got) sound.mode = *got;
  sound.set = std::make_unique<SoundSet>(silent_set(show, timeline));
  for (std::size_t i = 0; i < show.cues.size(); ++i) {
    if (!there[i]) continue;
    try {
      open_into(*sound.set, i, show, sound.mode);
    } catch (const InputError& error) {
      log.warn(Topic::kSound, fmt::format("cue {}: {}; it is silent", show.cues[i].name, error.what()));
    }
  }
  return sound;
}

SoundThread::SoundThread(const SoundSettings& settings, OpenSound sound, Clock& clock, ControlLink& link)
    : clock_(clock),
      output_(std::move(sound.output)),
      sound_(settings, std::move(sound.set), *output_, sound.mode, sound.opened, clock, link) {
  thread_ = std::thread([this] {
    while (!stopping_) {
      sound_.step();
      clock_.sleep_until(clock_.now() + ShowSound::kTurn);
    }
  });
}

SoundThread::~SoundThread() {
  stopping_ = true;
  thread_.join();
}

}  // namespace cupola
