// Reading files whole or in parts.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/file_bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "pipeline/frame/error.h"

namespace cupola {

RegularFile::RegularFile(const std::filesystem::path& path, const char* expected) : path_(path) {
  // Without O_NONBLOCK opening a FIFO would wait for its writer.
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor_ < 0) {
    throw InputError(fmt::format("{}: {}; expected {}", path.string(), std::strerror(errno), expected));
  }
  struct stat status {};
  const bool known = ::fstat(descriptor_, &status) == 0;
  const char* trouble = nullptr;
  if (known && S_ISDIR(status.st_mode)) {
    trouble = "is a folder";
  } else if (!known || !S_ISREG(status.st_mode)) {
    trouble = "is not a regular file";
  } else if (status.st_size == 0) {
    trouble = "is empty";
  }
  if (trouble != nullptr) {
    ::close(descriptor_);
    throw InputError(fmt::format("{}: {}; expected {}", path.string(), trouble, expected));
  }
  size_ = status.st_size;
}

RegularFile::~RegularFile() {
  ::close(descriptor_);
}

void RegularFile::read_at(std::int64_t offset, void* to, std::size_t count) const {
  auto* target = static_cast<std::byte*>(to);
  while (count > 0) {
    const ssize_t got = ::pread(descriptor_, target, count, offset);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError(fmt::format("{}: {}", path_.string(), std::strerror(errno)));
    if (got == 0)
      throw InputError(fmt::format("{}: ends at byte {}, {} too early", path_.string(), offset, count));
    target += got;
    offset += got;
    count -= static_cast<std::size_t>(got);
  }
}

void read_file(const std::filesystem::path& path, const char* expected, FileBytes& bytes) {
  const RegularFile file(path, expected);
  if (file.size() > kLargestFile) {
    throw InputError(
        fmt::format("{}: has {} bytes; expected at most {}", path.string(), file.size(), kLargestFile));
  }
  bytes.resize(static_cast<std::size_t>(file.size()));
  file.read_at(0, bytes.data(), bytes.size());
}

}  // namespace cupola
