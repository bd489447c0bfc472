// A DMA-BUF that is read by the processor: mapped once, its caches told before and after each reading.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

namespace cupola {

class DmaBufMemory {
 public:
  // The first `bytes` of `descriptor`, which is borrowed for this object's life. data() is null and error()
  // says why when it cannot be mapped.
  DmaBufMemory(int descriptor, std::size_t bytes) noexcept;
  ~DmaBufMemory();
  DmaBufMemory(DmaBufMemory&& other) noexcept;
  DmaBufMemory& operator=(DmaBufMemory&&) = delete;

  const std::uint8_t* data() const noexcept { return data_; }
  std::size_t bytes() const noexcept { return bytes_; }
  int descriptor() const noexcept { return descriptor_; }
  int error() const noexcept { return error_; }

  // What the device wrote is seen from the one call to the other. Memory that is no DMA-BUF needs neither.
  void begin_reading() const noexcept;
  void end_reading() const noexcept;

 private:
  int descriptor_;
  std::uint8_t* data_ = nullptr;
  std::size_t bytes_;
  int error_ = 0;
};

}  // namespace cupola
