// Fuzzes what a camera may send as JPEG: any bytes are a picture, damaged, or of another kind.
// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/camera/camera_planes.h"
#include "hal/camera/jpeg_decoder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static cupola::JpegDecoder decoder;
  const std::span<const std::uint8_t> jpeg(data, size);
  const auto kind = decoder.look(jpeg);
  if (!kind || kind->width * std::int64_t{kind->height} > 300'000) return 0;  // only slow
  std::array<std::vector<std::uint8_t>, 3> memory;
  std::array<cupola::JpegPlane, 3> planes;
  for (int p = 0; p < cupola::plane_count(kind->format); ++p) {
    const auto shape =
        cupola::plane_shape(kind->format, p, cupola::jpeg_room(kind->width), cupola::jpeg_room(kind->height));
    const auto i = static_cast<std::size_t>(p);
    memory[i].resize(static_cast<std::size_t>(shape.row_bytes * shape.rows));
    planes[i] = {memory[i].data(), shape.row_bytes};
  }
  decoder.decode(jpeg, *kind, planes, kind->height / 2);
  decoder.decode(jpeg, *kind, planes, kind->height);
  return 0;
}
