// The sounds that a show names, opened, and the thread that plays them.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "firmware/show.h"
#include "firmware/show_sound.h"

namespace cupola {

// The file of the cue's sound: its own, or that of its pictures. Empty where it has none.
std::string sound_file(const Cue& cue, const Rig& rig);

// Opens what the cue names; throws InputError. `channels` 0: as many as it has.
std::unique_ptr<SoundTrack> open_cue_sound(const Cue& cue, const Rig& rig, int rate, int channels);

// Which part of `track` is that of a cue of this timing, at `rate` frames a second.
SoundPart sound_part(const Cue& cue, const CueTiming& timing, const SoundTrack& track, int rate);

// All that the show names, for a device of that mode; throws InputError.
std::unique_ptr<SoundSet> open_sounds(const Show& show, const Timeline& timeline, const SoundMode& mode);

// A device, what it takes, and the sounds for it.
struct OpenSound {
  std::unique_ptr<SoundOutput> output;
  SoundMode mode;
  bool opened = false;  // else it is away
  std::unique_ptr<SoundSet> set;
};

// The machine's. What cannot be opened is said and silent: the pictures go on. None where the program has no
// sound, which is said too. `clock` is borrowed for the output's life.
std::optional<OpenSound> open_sound_device(const Show& show, const Timeline& timeline, Clock& clock,
                                           EventLog& log);

// The show's sound, for as long as it lives.
class SoundThread {
 public:
  // `clock` and `link` are borrowed.
  SoundThread(const SoundSettings& settings, OpenSound sound, Clock& clock, ControlLink& link);
  ~SoundThread();
  SoundThread(const SoundThread&) = delete;
  SoundThread& operator=(const SoundThread&) = delete;

 private:
  Clock& clock_;
  std::unique_ptr<SoundOutput> output_;
  ShowSound sound_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace cupola
