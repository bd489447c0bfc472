// Pictures whose rows lie so far apart that every 32-bit offset overflows; pages nobody touches cost nothing.
// SPDX-License-Identifier: MIT
#pragma once

#include <sys/mman.h>

#include "pipeline/frame/image.h"

namespace cupola::test {

// All zero at first. empty() where the system will not reserve so much.
class SparseImage {
 public:
  SparseImage(PixelFormat format, Size size, std::ptrdiff_t stride) {
    const auto plane = static_cast<std::size_t>(stride) * static_cast<std::size_t>(size.height);
    bytes_ = plane * static_cast<std::size_t>(plane_count(format));
    memory_ =
        mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    view_.format = format;
    view_.size = size;
    for (int p = 0; p < plane_count(format) && !empty(); ++p) {
      view_.planes[static_cast<std::size_t>(p)] = {
          static_cast<std::byte*>(memory_) + static_cast<std::size_t>(p) * plane, stride};
    }
  }
  ~SparseImage() {
    if (!empty()) munmap(memory_, bytes_);
  }
  SparseImage(const SparseImage&) = delete;
  SparseImage& operator=(const SparseImage&) = delete;

  bool empty() const { return memory_ == MAP_FAILED; }
  const MutableImage& pixels() { return view_; }
  std::size_t bytes() const { return bytes_; }

 private:
  void* memory_ = MAP_FAILED;
  std::size_t bytes_ = 0;
  MutableImage view_;
};

}  // namespace cupola::test
