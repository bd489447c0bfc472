// An append-only list: a line that was cut short by the end of its process counts as not written.
// SPDX-License-Identifier: MIT
#include "firmware/render_state.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <vector>

#include "pipeline/frame/checksum.h"
#include "pipeline/frame/error.h"

namespace cupola {

namespace fs = std::filesystem;

RenderState::RenderState(fs::path file, const std::string& key) : file_(std::move(file)) {
  descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail(errno);
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    ::close(descriptor_);
    throw Failure(fmt::format("{}: another render is writing these frames", file_.parent_path().string()));
  }
  read_lines(fmt::format("cupola render {}", key));
  append(fmt::format("process {}\n", ::getpid()));
}

RenderState::~RenderState() {
  ::close(descriptor_);
}

void RenderState::read_lines(const std::string& key) {
  std::string text;
  std::vector<char> part(65536);
  for (;;) {
    const ssize_t got = ::read(descriptor_, part.data(), part.size());
    if (got < 0 && errno != EINTR) fail(errno);
    if (got == 0) break;
    if (got > 0) text.append(part.data(), static_cast<std::size_t>(got));
  }
  const std::size_t whole = text.rfind('\n') + 1;  // 0 where there is none
  std::istringstream lines(text.substr(0, whole));
  std::string line;
  if (!std::getline(lines, line) || line != key) {
    if (::ftruncate(descriptor_, 0) != 0) fail(errno);
    append(key + "\n");
    return;
  }
  if (whole != text.size() && ::ftruncate(descriptor_, static_cast<off_t>(whole)) != 0) fail(errno);
  std::vector<std::string> leftovers;  // as AtomicFile names its temporary files
  while (std::getline(lines, line)) {
    long long number = 0;
    unsigned long long bytes = 0;
    if (std::sscanf(line.c_str(), "frame %lld %llu", &number, &bytes) == 2) bytes_[number] = bytes;
    if (std::sscanf(line.c_str(), "process %lld", &number) == 1)
      leftovers.push_back(fmt::format(".png.{}-", number));
  }
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(file_.parent_path(), error)) {
    const std::string name = entry.path().filename().string();
    for (const std::string& leftover : leftovers) {
      if (name.find(leftover) != std::string::npos && name.ends_with(".tmp")) fs::remove(entry.path(), error);
    }
  }
}

bool RenderState::done(std::int64_t frame, const fs::path& written) const {
  const auto found = bytes_.find(frame);
  std::error_code error;
  return found != bytes_.end() && fs::file_size(written, error) == found->second && !error;
}

void RenderState::add(std::int64_t frame, const fs::path& written) {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(written, error);
  if (!error) append(fmt::format("frame {} {}\n", frame, bytes));
}

void RenderState::finish() {
  std::error_code error;
  fs::remove(file_, error);
}

void RenderState::append(const std::string& line) {
  const ssize_t written = ::write(descriptor_, line.data(), line.size());
  if (written < 0) fail(errno);
  if (static_cast<std::size_t>(written) != line.size()) fail(ENOSPC);
}

void RenderState::fail(int error) const {
  throw Failure(fmt::format("{}: cannot be written: {}", file_.string(), std::strerror(error)));
}

std::string render_key(const std::string& text, std::span<const std::uint64_t> numbers) {
  const std::uint64_t first = checksum(std::as_bytes(std::span(text)));
  return fmt::format("{:016x}", checksum(std::as_bytes(numbers), first));
}

}  // namespace cupola
