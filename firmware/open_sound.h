// The sounds that a show names, opened, and the thread that plays them.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "firmware/show.h"
#include "firmware/show_sound.h"

namespace cupola {

// The file of the cue's sound: its own, or that of its pictures. Empty where it has none.
std::string sound_file(const Cue& cue, const Rig& rig);

// Opens what the cue names; throws InputError. `channels` 0: as many as it has.
std::unique_ptr<SoundTrack> open_cue_sound(const Cue& cue, const Rig& rig, int rate, int channels);

// Which part of `track` is that of a cue of this timing, at `rate` frames a second.
SoundPart sound_part(const Cue& cue, const CueTiming& timing, const SoundTrack& track, int rate);

// The show's sound, on the machine's device, for as long as it lives. What cannot be opened is said and
// silent: the pictures go on.
class SoundThread {
 public:
  // `timeline`: the show's. `clock` and `link` are borrowed.
  SoundThread(const Show& show, const Timeline& timeline, Clock& clock, ControlLink& link);
  ~SoundThread();
  SoundThread(const SoundThread&) = delete;
  SoundThread& operator=(const SoundThread&) = delete;

 private:
  Clock& clock_;
  std::unique_ptr<SoundOutput> output_;
  std::unique_ptr<ShowSound> sound_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace cupola
