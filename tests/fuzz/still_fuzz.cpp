// Fuzzes the readers of stills: any bytes are a picture or an InputError, whole or in part.
// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstdint>
#include <span>

#include "pipeline/frame/error.h"
#include "pipeline/frame/still.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = std::as_bytes(std::span(data, size));
  try {
    const cupola::StillInfo info = cupola::probe_still(file, "fuzz");
    if (std::int64_t{info.size.width} * info.size.height > 300'000) return 0;  // only slow
    cupola::ImageBuffer image(info.format, info.size);
    const int height = info.size.height;
    cupola::decode_still(file, "fuzz", image.pixels(), {height / 3, height - height / 4});
    cupola::decode_still(file, "fuzz", image.pixels());
  } catch (const cupola::InputError&) {
  }
  return 0;
}
