// Fuzzes the Y4M reader: any file is a video or an InputError.
// SPDX-License-Identifier: MIT
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "pipeline/frame/error.h"
#include "pipeline/frame/y4m_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const int descriptor = ::memfd_create("y4m", MFD_CLOEXEC);
  if (descriptor < 0 || ::write(descriptor, data, size) != static_cast<ssize_t>(size)) std::abort();
  try {
    cupola::Y4mReader reader("/proc/self/fd/" + std::to_string(descriptor));
    cupola::ImageBuffer image(reader.format(), reader.size());
    reader.read(reader.frames() - 1, image.pixels());
    reader.read(0, image.pixels(), {reader.size().height / 3, reader.size().height - 1});
  } catch (const cupola::InputError&) {
  }
  ::close(descriptor);
  return 0;
}
