// Sound through ALSA; its plugins lead to PipeWire, PulseAudio and files.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include "hal/sound/sound_output.h"
#include "hal/time/clock.h"

namespace cupola {

// `device` as `aplay -L` names it, "default" among them; `clock` is borrowed. Null where the program was
// built without sound.
std::unique_ptr<SoundOutput> make_alsa_sound(const std::string& device, Clock& clock);

}  // namespace cupola
