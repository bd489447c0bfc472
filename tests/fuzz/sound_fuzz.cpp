// Fuzzes sound files: any file is a sound or an InputError, wherever one begins to read.
// SPDX-License-Identifier: MIT
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "pipeline/frame/error.h"
#include "pipeline/sound/sound_track.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const int descriptor = ::memfd_create("sound", MFD_CLOEXEC);
  if (descriptor < 0 || ::write(descriptor, data, size) != static_cast<ssize_t>(size)) std::abort();
  try {
    const auto sound = cupola::open_sound("/proc/self/fd/" + std::to_string(descriptor), 48000, 2);
    std::vector<float> samples(2 * 1000);
    for (const std::int64_t first :
         {std::int64_t{0}, sound->length() / 2, sound->length(), std::int64_t{500}}) {
      try {
        sound->read(first, samples);
      } catch (const cupola::InputError&) {
      }
    }
  } catch (const cupola::InputError&) {
  }
  ::close(descriptor);
  return 0;
}
