// Fuzzes the reader of cameras' recordings: every record that it finds can be read to its last byte.
// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <stdexcept>

#include "hal/camera/camera_planes.h"
#include "hal/camera/recording_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const cupola::RecordingReader reader(std::as_bytes(std::span(data, size)));
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < reader.size(); ++i) {
      const cupola::CameraRecord record = reader.at(i);
      sum += std::strlen(record.trouble.step) + cupola::is_whole(record.frame);
      for (const cupola::CameraPlane& plane : record.frame.planes) {
        if (plane.data) sum = std::accumulate(plane.data, plane.data + plane.bytes, sum);
      }
    }
    if (sum > 300 * static_cast<std::uint64_t>(size)) std::abort();
  } catch (const std::runtime_error&) {
  }
  return 0;
}
