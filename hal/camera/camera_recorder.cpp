// Sayings go through a ring to the copier, blocks round between it and the writer.
// SPDX-License-Identifier: MIT
#include "hal/camera/camera_recorder.h"

#include <cerrno>
#include <cstring>
#include <exception>
#include <utility>

namespace cupola {

namespace {

constexpr int kStop = -1;

}  // namespace

CameraRecorder::CameraRecorder(const std::filesystem::path& file, Writing writing)
    : file_(file), writing_(writing) {
  if (writing_ == Writing::kAtOnce) return;
  for (const HandOver* ring : {&waiting_, &free_, &full_}) {
    if (ring->descriptor() < 0) throw std::system_error(EMFILE, std::generic_category(), "eventfd");
  }
  for (std::size_t block = 0; block < kBlocks; ++block) free_.push(static_cast<int>(block));
  copier_ = std::thread([this] { copy_frames(); });
  try {
    writer_ = std::thread([this] { write_blocks(); });
  } catch (const std::system_error&) {
    waiting_.push(kStop);
    copier_.join();
    throw;
  }
}

CameraRecorder::~CameraRecorder() {
  if (writing_ == Writing::kAtOnce) return;
  while (!waiting_.push(kStop)) std::this_thread::yield();
  copier_.join();
  full_.push(kStop);  // it has room for every block and this
  writer_.join();
}

void CameraRecorder::say(const CameraRecord& record) noexcept {
  if (error_.load(std::memory_order_relaxed) != 0) return;
  if (writing_ == Writing::kAtOnce) return write(record);
  const std::size_t ahead = said_ - heard_.load(std::memory_order_acquire);
  const bool is_frame = record.kind == RecordKind::kFrame;
  const auto buffer = static_cast<std::size_t>(record.frame.buffer);
  if (is_frame && (ahead >= kFramesAhead || buffer >= kBuffers)) {
    passed_over_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  Saying& saying = sayings_[said_ % sayings_.size()];
  saying.record = record;
  if (is_frame) {
    saying.turn = buffers_[buffer].load(std::memory_order_relaxed) / 4 + 1;
    buffers_[buffer].store(4 * saying.turn + kWaiting, std::memory_order_relaxed);  // the ring publishes it
  }
  if (ahead < HandOver::kCapacity && waiting_.push(static_cast<int>(said_ % sayings_.size()))) {
    ++said_;
  } else {
    error_.store(ENOBUFS, std::memory_order_relaxed);  // without a start or a loss the rest would be wrong
  }
}

bool CameraRecorder::take_back(int number) noexcept {
  const auto buffer = static_cast<std::size_t>(number);
  if (buffer >= kBuffers) return true;
  std::uint64_t seen = buffers_[buffer].load(std::memory_order_acquire);
  if (seen % 4 == kWaiting &&
      buffers_[buffer].compare_exchange_strong(seen, seen - kWaiting + kMine, std::memory_order_acquire)) {
    return true;
  }
  return seen % 4 != kCopying;
}

void CameraRecorder::take_all_back() noexcept {
  for (std::size_t buffer = 0; buffer < kBuffers; ++buffer) {
    while (!take_back(static_cast<int>(buffer))) {
      const std::uint64_t seen = buffers_[buffer].load(std::memory_order_acquire);
      if (seen % 4 == kCopying) buffers_[buffer].wait(seen, std::memory_order_acquire);
    }
  }
}

RecorderCounts CameraRecorder::counts() const noexcept {
  return {frames_.load(std::memory_order_relaxed), passed_over_.load(std::memory_order_relaxed),
          error_.load(std::memory_order_relaxed)};
}

void CameraRecorder::copy_frames() noexcept {
  constexpr int kNone = -1;
  int place = kNone;  // the block to fill next
  for (;;) {
    const int number = waiting_.wait();
    if (number == kStop) return;
    const Saying& saying = sayings_[static_cast<std::size_t>(number)];
    const bool is_frame = saying.record.kind == RecordKind::kFrame;
    // Troubles wait for the disk; frames do not, as they are many and their buffers wanted.
    if (place == kNone) place = is_frame ? free_.pop().value_or(kNone) : free_.wait();
    if (place != kNone && copy(saying, blocks_[static_cast<std::size_t>(place)])) {
      full_.push(std::exchange(place, kNone));
    } else {
      passed_over_.fetch_add(1, std::memory_order_relaxed);
    }
    heard_.fetch_add(1, std::memory_order_release);
  }
}

// False where the frame was taken back before.
bool CameraRecorder::copy(const Saying& saying, Block& block) noexcept {
  block.record = saying.record;
  if (saying.record.kind != RecordKind::kFrame) return true;
  std::atomic<std::uint64_t>& buffer = buffers_[static_cast<std::size_t>(saying.record.frame.buffer)];
  std::uint64_t expected = 4 * saying.turn + kWaiting;
  if (!buffer.compare_exchange_strong(expected, 4 * saying.turn + kCopying, std::memory_order_acquire))
    return false;
  bool fits = true;
  try {
    std::size_t bytes = 0;
    for (const CameraPlane& plane : saying.record.frame.planes) bytes += plane.data ? plane.bytes : 0;
    if (block.memory.size() < bytes) block.memory.resize(bytes);
  } catch (const std::exception&) {
    fits = false;
  }
  std::uint8_t* at = block.memory.data();
  for (CameraPlane& plane : block.record.frame.planes) {
    if (!fits || !plane.data) continue;
    std::memcpy(at, plane.data, plane.bytes);
    plane.data = at;
    at += plane.bytes;
  }
  buffer.store(4 * saying.turn + kMine, std::memory_order_release);
  buffer.notify_all();
  return fits;
}

void CameraRecorder::write_blocks() noexcept {
  for (;;) {
    const int number = full_.wait();
    if (number == kStop) return;
    write(blocks_[static_cast<std::size_t>(number)].record);
    free_.push(number);
  }
}

void CameraRecorder::write(const CameraRecord& record) noexcept {
  if (!file_.append(record)) {
    error_.store(file_.error(), std::memory_order_relaxed);
  } else if (record.kind == RecordKind::kFrame) {
    frames_.fetch_add(1, std::memory_order_relaxed);
  }
}

}  // namespace cupola
