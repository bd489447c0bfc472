// Files written under a temporary name and renamed when they are complete.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

constexpr std::size_t kGather = std::size_t{256} << 10;

}  // namespace

AtomicFile::AtomicFile(const std::filesystem::path& target) : target_(target) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::file_status status = fs::status(target, ignored);
  if (fs::is_directory(status)) throw Failure(fmt::format("{}: is a folder", target.string()));
  if (fs::exists(status) && !fs::is_regular_file(status)) {  // renaming would replace a device by a file
    descriptor_ = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) fail(errno);
    return;
  }
  if (fs::is_symlink(target, ignored) && fs::exists(status)) target_ = fs::canonical(target, ignored);
  for (int attempt = 0; descriptor_ < 0; ++attempt) {  // a name may be left from a run that was killed
    temporary_ = target_;
    temporary_ += fmt::format(".{}-{}.tmp", ::getpid(), attempt);
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && (errno != EEXIST || attempt == 9999)) {
      temporary_.clear();
      fail(errno);
    }
  }
}

AtomicFile::AtomicFile(int descriptor, std::string name)
    : target_(std::move(name)), descriptor_(descriptor), borrowed_(true) {}

AtomicFile::~AtomicFile() {
  abandon();
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})),
      descriptor_(std::exchange(other.descriptor_, -1)),
      borrowed_(other.borrowed_),
      pending_(std::move(other.pending_)) {}

void AtomicFile::write(std::span<const std::byte> bytes) {
  if (pending_.size() + bytes.size() > kGather) {
    write_through(pending_);
    pending_.clear();
  }
  if (bytes.size() >= kGather) return write_through(bytes);
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
}

void AtomicFile::write_through(std::span<const std::byte> bytes) {
  if (descriptor_ < 0) fail(EBADF);
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(errno);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void AtomicFile::commit() {
  write_through(pending_);
  pending_.clear();
  if (!temporary_.empty() && ::fdatasync(descriptor_) != 0) fail(errno);
  if (!borrowed_ && ::close(std::exchange(descriptor_, -1)) != 0) fail(errno);
  if (!temporary_.empty()) {
    if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
    temporary_.clear();
  }
  descriptor_ = -1;
}

void AtomicFile::abandon() noexcept {
  if (descriptor_ >= 0 && !borrowed_) ::close(descriptor_);
  descriptor_ = -1;
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  temporary_.clear();
}

void AtomicFile::fail(int error) {
  abandon();
  throw Failure(fmt::format("{}: cannot be written: {}", target_.string(), std::strerror(error)));
}

}  // namespace cupola
