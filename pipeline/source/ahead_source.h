// Faces from files, decoded ahead of need by a thread of their own into a bounded queue.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "pipeline/source/face_streams.h"

namespace cupola {

// Frames are counted in positions, which only ever rise: the part's frames over and over, so that after its
// last frame the first one follows. A jump, back too, is a step to a higher position. The thread decodes on
// from the position asked for last, at most kAhead frames, and never one that is past. A set of kAhead + 1
// pictures is allocated in prepare(), nothing later but what the decoders need for themselves.
//
// fetch() takes the newest frame that is due. When it is not decoded yet an older one that is due too is
// taken, or none; with `in_step` it is waited for instead, so that the same frames are shown every time.
// fetch() and rest() belong to one thread, which they neither make wait nor let allocate.
class AheadSource final : public FileFaces {
 public:
  static constexpr int kAhead = 6;  // frames

  // Frames `first` to `first` + `count` - 1 are played. At least one stream of `faces` moves.
  AheadSource(FaceStreams faces, std::int64_t first, std::int64_t count, bool in_step);
  ~AheadSource() override;
  AheadSource(const AheadSource&) = delete;
  AheadSource& operator=(const AheadSource&) = delete;

  std::vector<Size> face_sizes() const override { return faces_.face_sizes(); }
  PixelFormat format() const override { return format_; }
  std::optional<std::int64_t> length() const override { return length_; }
  void prepare(std::span<const NeededRegion> needed) override;  // returns when the first frame is decoded
  Fetch fetch(std::int64_t frame, FaceSet& faces) noexcept override;

  FileCounts counts() const noexcept override;
  const char* trouble() const noexcept override { return trouble_.data(); }
  void rest() noexcept override;
  FileQueue queue() const noexcept override {
    return {static_cast<int>(produced_.load() - consumed_.load()), static_cast<int>(queue_.size())};
  }

 private:
  using Trouble = std::array<char, 400>;
  struct Frame {
    std::int64_t position = 0;
    bool failed = false;                // then only `trouble` has a meaning
    std::vector<std::size_t> images;    // a stream each: which of its images
    bool changes_known = false;         // else anything may have changed
    std::vector<ChangedCells> changed;  // a place each, since the good frame decoded before
    Trouble trouble{};
  };
  struct Stream {
    RowRange rows;
    std::vector<ImageBuffer> images;
    std::atomic<std::size_t> held{0};  // the image lent by the last fetch
    std::size_t newest = 0;            // the decoder's: of the last good frame
  };

  std::int64_t frame_at(std::int64_t position) const { return first_ + position % count_; }
  Frame& slot(std::int64_t index) { return queue_[static_cast<std::size_t>(index) % queue_.size()]; }

  // The decoder's thread.
  void decode_ahead() noexcept;
  void decode(std::int64_t position, Frame& frame) noexcept;
  void read_streams(std::int64_t position, Frame& frame);
  void compare(Frame& frame) const;
  std::size_t free_image(std::size_t stream) const;

  // The loop's thread.
  void ask(std::int64_t position) noexcept;
  void take(const Frame& frame) noexcept;
  void lend(FaceSet& faces) const noexcept;
  Fetch show(FaceSet& faces) noexcept;
  void count_missing(std::int64_t position) noexcept;

  FaceStreams faces_;
  const std::int64_t first_;
  const std::int64_t count_;
  const bool in_step_;
  const PixelFormat format_;
  const std::optional<std::int64_t> length_;
  std::vector<Stream> streams_;
  std::vector<NeededRegion> needed_;

  // Frames [consumed_, produced_) are in the queue: the decoder's until produced, the loop's until consumed.
  std::vector<Frame> queue_;
  std::atomic<std::int64_t> produced_{0};
  std::atomic<std::int64_t> consumed_{0};
  std::atomic<std::int64_t> asked_{0};  // a position
  std::atomic<int> bell_{0};            // rises when the decoder has something to look at
  std::atomic<bool> stopping_{false};

  // The decoder's.
  bool any_good_ = false;
  bool whole_ = false;  // what the streams read last is a frame
  std::atomic<std::int64_t> repeated_{0};
  std::atomic<std::int64_t> decoded_{0};
  std::atomic<std::int64_t> decode_ns_{0};
  std::atomic<std::int64_t> longest_ns_{0};

  // The loop's.
  std::int64_t floor_ = 0;     // frames before this position are of no use: they precede a jump
  std::int64_t taken_ = -1;    // the position taken last
  std::int64_t shown_ = -1;    // the position lent
  std::int64_t counted_ = -1;  // the position that was missing last
  bool taken_failed_ = false;
  bool has_good_ = false;  // of what was taken and not lent: good_
  std::int64_t good_position_ = 0;
  std::vector<std::size_t> good_;
  bool changes_known_ = false;  // of what was taken since the last frame was lent
  std::vector<ChangedCells> changed_;
  std::vector<ChangedCells> told_;  // what the last fetch gave
  FileCounts counts_;
  Trouble trouble_{};

  std::thread decoder_;
};

}  // namespace cupola
