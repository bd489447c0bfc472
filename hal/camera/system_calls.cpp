// Straight through to the kernel.
// SPDX-License-Identifier: MIT
#include "hal/camera/system_calls.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace cupola {

int LinuxCalls::open(const char* path, int flags) noexcept {
  return ::open(path, flags);
}
int LinuxCalls::close(int descriptor) noexcept {
  return ::close(descriptor);
}
int LinuxCalls::ioctl(int descriptor, unsigned long request, void* argument) noexcept {
  return ::ioctl(descriptor, request, argument);
}
void* LinuxCalls::mmap(std::size_t length, int descriptor, long offset) noexcept {
  return ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, offset);
}
int LinuxCalls::munmap(void* address, std::size_t length) noexcept {
  return ::munmap(address, length);
}

}  // namespace cupola
