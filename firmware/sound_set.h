// What a show has to say: a sound a cue, opened for the device, and the show's timeline.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/timeline.h"
#include "pipeline/sound/sound_ahead.h"

namespace cupola {

// A cue's sound, or none, and how long its old sound takes to fall silent when the cue begins.
struct CueSound {
  std::string cue;
  std::unique_ptr<SoundAhead> ahead;
  std::chrono::nanoseconds fade{0};
  std::optional<std::int64_t> length = std::nullopt;  // frames that the file promises
  // ShowSound's:
  bool heard = false;     // and is to go back to its begin
  bool end_said = false;  // in the log
};

struct SoundSet {
  std::vector<CueSound> sounds;  // one a cue
  Timeline timeline;
  std::chrono::nanoseconds delay{0};  // SoundSettings'
  int show = 0;                       // PlayerStatus::show_number where the cues are these
};

}  // namespace cupola
