// What a driver of the kernel's devices asks of the system: tests put a device of their own below it.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace cupola {

// Each as the system call of its name: -1 (mmap: MAP_FAILED) and errno where it fails.
class SystemCalls {
 public:
  virtual ~SystemCalls() = default;
  virtual int open(const char* path, int flags) noexcept = 0;
  virtual int close(int descriptor) noexcept = 0;
  virtual int ioctl(int descriptor, unsigned long request, void* argument) noexcept = 0;
  // Shared, to read and write, from `offset` of the descriptor on.
  virtual void* mmap(std::size_t length, int descriptor, long offset) noexcept = 0;
  virtual int munmap(void* address, std::size_t length) noexcept = 0;
};

class LinuxCalls final : public SystemCalls {
 public:
  int open(const char* path, int flags) noexcept override;
  int close(int descriptor) noexcept override;
  int ioctl(int descriptor, unsigned long request, void* argument) noexcept override;
  void* mmap(std::size_t length, int descriptor, long offset) noexcept override;
  int munmap(void* address, std::size_t length) noexcept override;
};

}  // namespace cupola
