// Without FFmpeg's libraries sound is refused by name.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "pipeline/frame/error.h"
#include "pipeline/sound/sound_track.h"

namespace cupola {

std::unique_ptr<SoundTrack> open_sound(const std::filesystem::path& path, int /*rate*/, int /*channels*/) {
  throw InputError(fmt::format("{}: this program was built without sound", path.string()));
}

}  // namespace cupola
