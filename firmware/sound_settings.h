// The show file's [sound].
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <string>

#include "pipeline/settings/settings.h"

namespace cupola {

struct SoundSettings {
  std::string device = "default";     // as `aplay -L` names them
  int channels = 0;                   // 0: as many as the sound with the most has
  int volume = 100;                   // percent, to begin with
  bool master = false;                // the show's time follows the sound's clock
  std::chrono::nanoseconds delay{0};  // of the sound against the picture, which projectors show late
};

// Throws InputError.
SoundSettings read_sound(SettingsTable table);

}  // namespace cupola
