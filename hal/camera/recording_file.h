// The file of all that one camera said: its starts, its frames with every byte as it came, and its troubles.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "hal/camera/camera.h"

namespace cupola {

enum class RecordKind : std::uint8_t { kStarted, kRefused, kFrame, kDamaged, kLost };

struct CameraRecord {
  RecordKind kind = RecordKind::kStarted;
  std::chrono::nanoseconds seen_at{0};  // when it was polled, since the recording began
  CameraMode mode;                      // of kStarted
  CameraTrouble trouble;                // of kRefused and kLost
  CameraFrame frame;  // of kFrame; of kDamaged only the sequence. Also stamped since the begin
};

// Little-endian, any number of records: a head of 192 bytes, the planes' bytes one after the other, zeros up
// to the next multiple of 64. Before them a head of 64 bytes with the file's name and version.
class RecordingWriter {
 public:
  // Writes to FILE.part; throws std::system_error where it cannot be made.
  explicit RecordingWriter(std::filesystem::path file);
  // Cuts off what was not written whole, and gives the file its name.
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  // False from the first record on that could not be written: the disk is full.
  bool append(const CameraRecord& record) noexcept;
  int error() const noexcept { return error_; }  // errno of that, or 0
  std::uint64_t bytes() const noexcept { return whole_; }

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  int error_ = 0;
  std::uint64_t whole_ = 0;  // bytes of whole records, and of the file's head
};

class RecordingReader {
 public:
  // Reads FILE, or where there is none FILE.part, which somebody wrote who was killed. Throws
  // std::runtime_error where neither is a recording. The file is mapped: whoever cuts it short afterwards
  // ends the program.
  explicit RecordingReader(const std::filesystem::path& file);
  // Of bytes in memory, which outlive the reader.
  explicit RecordingReader(std::span<const std::byte> bytes);

  std::size_t size() const { return begins_.size(); }  // records
  // Pointers into the file's bytes, which live as long as the reader; frames keep what the driver said of
  // their planes, however strange, but for DMA-BUFs.
  CameraRecord at(std::size_t record) const;
  // Where the last whole record ends, and what comes after is none; the file's size where all are.
  std::size_t readable_bytes() const { return readable_; }
  bool is_whole() const { return readable_ == bytes_.size(); }

 private:
  struct Unmap {
    std::size_t count;
    void operator()(const std::byte* memory) const;
  };
  void find_records();

  std::unique_ptr<const std::byte, Unmap> mapped_{nullptr, Unmap{0}};
  std::span<const std::byte> bytes_;
  std::vector<std::uint64_t> begins_;
  std::size_t readable_ = 0;
};

}  // namespace cupola
