// Memory straight from the system.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/mapped_bytes.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <new>

namespace cupola {

void MappedBytes::Unmap::operator()(std::byte* memory) const {
  ::munmap(memory, count);
}

MappedBytes MappedBytes::zeros(std::size_t count) {
  if (count == 0) return {};
  void* memory = ::mmap(nullptr, count, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return {memory, {count, false}};
}

MappedBytes MappedBytes::of_file(const std::filesystem::path& file) {
  // Without O_NONBLOCK opening a FIFO would wait for its writer.
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return {};
  struct stat status {};
  void* memory = MAP_FAILED;
  const bool usable = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0;
  const auto count = static_cast<std::size_t>(status.st_size);
  if (usable) memory = ::mmap(nullptr, count, PROT_READ, MAP_PRIVATE | MAP_POPULATE, descriptor, 0);
  ::close(descriptor);
  if (memory == MAP_FAILED) return {};
  return {memory, {count, true}};
}

}  // namespace cupola
