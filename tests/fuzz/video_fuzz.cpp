// Fuzzes compressed videos: any file is a video or an InputError, whichever frame is asked for.
// SPDX-License-Identifier: MIT
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "pipeline/frame/error.h"
#include "pipeline/source/video_stream.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const int descriptor = ::memfd_create("video", MFD_CLOEXEC);
  if (descriptor < 0 || ::write(descriptor, data, size) != static_cast<ssize_t>(size)) std::abort();
  try {
    const auto video = cupola::open_video("/proc/self/fd/" + std::to_string(descriptor));
    const cupola::Size picture = video->size();
    if (std::int64_t{picture.width} * picture.height <= 300'000) {  // others are only slow
      cupola::ImageBuffer image(video->format(), picture);
      for (const std::int64_t frame : {*video->length() - 1, *video->length() / 2}) {
        try {
          video->read(frame, {picture.height / 3, picture.height}, image.pixels(), false);
        } catch (const cupola::InputError&) {
        }
      }
    }
  } catch (const cupola::InputError&) {
  }
  ::close(descriptor);
  return 0;
}
