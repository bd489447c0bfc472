// Bytes in whole pages of memory: fresh ones, or those of a file.
// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace cupola {

class MappedBytes {
 public:
  MappedBytes() = default;
  static MappedBytes zeros(std::size_t count);  // throws std::bad_alloc
  // The file's bytes as they are in the system's page cache, read only and read ahead; none where it is
  // missing, empty, unreadable or no regular file. Whoever cuts the file short afterwards ends the program:
  // it is for files that are only ever replaced, as AtomicFile does.
  static MappedBytes of_file(const std::filesystem::path& file);

  std::span<const std::byte> bytes() const { return {memory_.get(), memory_.get_deleter().count}; }
  std::span<std::byte> writable() {
    assert(!memory_.get_deleter().read_only);
    return {memory_.get(), memory_.get_deleter().count};
  }

 private:
  struct Unmap {
    std::size_t count;
    bool read_only;
    void operator()(std::byte* memory) const;
  };
  MappedBytes(void* memory, Unmap unmap) : memory_(static_cast<std::byte*>(memory), unmap) {}

  std::unique_ptr<std::byte, Unmap> memory_;
};

}  // namespace cupola
