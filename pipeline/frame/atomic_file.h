// A file that appears whole or not at all.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cupola {

// Writes to a temporary name in the target's folder; commit() flushes it to the disk and renames it.
// Destroyed before commit(), or after any failure, it leaves nothing behind and the target as it was. Devices
// and pipes are written straight. Every member but the destructor throws Failure naming the target and the
// cause.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& target);
  // A descriptor that is somebody else's and stays open, such as standard output; `name` is for messages. The
  // program must ignore SIGPIPE, so that a closed pipe is a Failure and not the end of it.
  AtomicFile(int descriptor, std::string name);
  ~AtomicFile();
  AtomicFile(AtomicFile&&) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;

  void write(std::span<const std::byte> bytes);
  void write(std::string_view text) { write(std::as_bytes(std::span(text))); }
  void commit();  // once, as the last call

 private:
  void write_through(std::span<const std::byte> bytes);
  void abandon() noexcept;
  [[noreturn]] void fail(int error);

  std::filesystem::path target_;
  std::filesystem::path temporary_;  // empty when written straight
  int descriptor_ = -1;
  bool borrowed_ = false;
  std::vector<std::byte> pending_;  // small writes are gathered
};

}  // namespace cupola
