// Reading [sound].
// SPDX-License-Identifier: MIT
#include "firmware/sound_settings.h"

#include <cmath>

namespace cupola {

SoundSettings read_sound(SettingsTable table) {
  SoundSettings sound;
  sound.device = table.text("device", sound.device);
  if (sound.device.empty()) table.refuse("device", "expected a device, as `aplay -L` names them");
  sound.channels = static_cast<int>(table.integer("channels", 1, 64, 0));
  sound.volume = static_cast<int>(table.integer("volume", 0, 100, 100));
  sound.master = table.flag("master", false);
  sound.delay = std::chrono::nanoseconds(std::llround(table.number("delay_ms", -1000.0, 1000.0, 0.0) * 1e6));
  table.finish();
  return sound;
}

}  // namespace cupola
