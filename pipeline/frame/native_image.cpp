// The buffer that owns a YUV picture.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/native_image.h"

namespace cupola {

NativeBuffer::NativeBuffer(NativeLayout layout, YuvColour colour, Size size)
    : view_{layout, colour, size, {}} {
  std::array<std::size_t, 3> first{};
  std::size_t lines = 0;
  for (std::size_t p = 0; p < plane_count(layout); ++p) {
    const Size bytes = plane_bytes(layout, size, p);
    // An odd number of cache lines: rows a power of two apart would fall into the same few sets of the cache.
    const std::size_t row = (static_cast<std::size_t>(bytes.width) + 63) / 64 | 1U;
    view_.planes[p].stride = static_cast<std::ptrdiff_t>(row * 64);
    first[p] = lines;
    lines += row * static_cast<std::size_t>(bytes.height);
  }
  memory_.resize(lines);
  for (std::size_t p = 0; p < plane_count(layout); ++p) view_.planes[p].data = memory_[first[p]].bytes.data();
}

}  // namespace cupola
