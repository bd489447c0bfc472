// A whole file in memory.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace cupola {

using FileBytes = std::vector<std::byte>;

inline constexpr std::int64_t kLargestFile = std::int64_t{2} << 30;

// Replaces the contents of `bytes`, whose memory is used again. Throws InputError for a file that is missing,
// unreadable, empty, larger than kLargestFile or no regular file; `expected` says in the message what should
// be there.
void read_file(const std::filesystem::path& path, const char* expected, FileBytes& bytes);

// An open regular file; throws as read_file does, but takes any size.
class RegularFile {
 public:
  RegularFile(const std::filesystem::path& path, const char* expected);
  ~RegularFile();
  RegularFile(const RegularFile&) = delete;
  RegularFile& operator=(const RegularFile&) = delete;

  std::int64_t size() const { return size_; }  // bytes, when it was opened
  // Throws InputError unless all `count` bytes are there.
  void read_at(std::int64_t offset, void* to, std::size_t count) const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::int64_t size_ = 0;
};

}  // namespace cupola
