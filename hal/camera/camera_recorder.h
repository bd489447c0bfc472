// Writes what one camera says to its file, beside the picture: one thread copies frames while they are lent,
// another writes and may wait for the disk as long as it likes. What they are too late for is passed over.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <thread>
#include <vector>

#include "hal/camera/hand_over.h"
#include "hal/camera/recording_file.h"

namespace cupola {

struct RecorderCounts {
  std::uint64_t frames = 0;       // written
  std::uint64_t passed_over = 0;  // given back before they were copied, or the disk was behind
  int error = 0;                  // errno of what ended the recording, or 0; ENOBUFS: it was a second behind
};

class CameraRecorder {
 public:
  enum class Writing : std::uint8_t {
    kAtOnce,     // in say(), every frame: for fake clocks
    kOnAThread,  // needs a clock that waits for nobody
  };
  static constexpr std::size_t kBlocks = 8;  // as large as a frame: 11 MB a camera of 1280 x 720 in NV12

  // Throws std::system_error where the file or the threads cannot be made.
  CameraRecorder(const std::filesystem::path& file, Writing writing);
  // Writes what was said, and ends. Every frame is to be taken back before.
  ~CameraRecorder();
  CameraRecorder(const CameraRecorder&) = delete;
  CameraRecorder& operator=(const CameraRecorder&) = delete;

  // From one thread at a time, which never waits. A frame's bytes may be read until it is taken back; a
  // buffer is said again only after that.
  void say(const CameraRecord& record) noexcept;
  // Whether nobody reads the buffer any more: false while it is being copied, which takes no longer than
  // that.
  bool take_back(int buffer) noexcept;
  // Waits for the one that is being copied.
  void take_all_back() noexcept;

  RecorderCounts counts() const noexcept;

 private:
  static constexpr std::size_t kBuffers = 32;  // of a camera
  static constexpr std::size_t kFramesAhead =
      HandOver::kCapacity / 2;  // waiting; the rest of the ring is for troubles
  // A buffer's turns are numbered, so that nobody takes a frame for the one before it: 4 * turn + state.
  enum State : std::uint64_t { kMine, kWaiting, kCopying };
  struct Saying {
    CameraRecord record;
    std::uint64_t turn = 0;  // of a frame's buffer, as it waits
  };
  struct Block {
    std::vector<std::uint8_t> memory;
    CameraRecord record;
  };

  void copy_frames() noexcept;
  bool copy(const Saying& saying, Block& block) noexcept;
  void write_blocks() noexcept;
  void write(const CameraRecord& record) noexcept;

  RecordingWriter file_;
  Writing writing_;
  std::array<std::atomic<std::uint64_t>, kBuffers> buffers_{};
  std::array<Saying, 2 * HandOver::kCapacity> sayings_;  // twice, as the last one taken is still being read
  std::size_t said_ = 0;
  std::atomic<std::size_t> heard_{0};
  HandOver waiting_;  // sayings; or kStop
  std::array<Block, kBlocks> blocks_;
  HandOver free_;  // blocks
  HandOver full_;  // blocks; or kStop
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<std::uint64_t> passed_over_{0};
  std::atomic<int> error_{0};
  std::thread copier_;
  std::thread writer_;
};

}  // namespace cupola
