// A cue's sound, decoded ahead of need by a thread of its own into a bounded queue.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "pipeline/sound/sound_track.h"

namespace cupola {

// Which frames of the track are the cue's.
struct SoundPart {
  std::int64_t first = 0;
  std::optional<std::int64_t> length = std::nullopt;  // none: to the track's end
  bool loop = false;                                  // begin again after the last; else silence
};

// Frames are counted from the cue's begin and only ever rise: those of a loop over and over, and after the
// sound's end silence. The thread decodes on from where was read last, at most `ahead` frames.
class SoundAhead {
 public:
  // With `in_step` what is not there yet is waited for: where no time passes meanwhile.
  SoundAhead(std::unique_ptr<SoundTrack> track, int channels, const SoundPart& part, std::int64_t ahead,
             bool in_step);
  ~SoundAhead();
  SoundAhead(const SoundAhead&) = delete;
  SoundAhead& operator=(const SoundAhead&) = delete;

  // Frames from `first` on, as many as are there of those that `into` holds; says how many. Back, or far on
  // from where the last call ended, is a jump: there is nothing there at first. Does not wait for the
  // decoder.
  std::size_t read(std::int64_t first, std::span<float> into) noexcept;
  // Back to its begin, for when it is next needed.
  void rest() noexcept { read(0, {}); }

  std::string name() const { return track_->name(); }
  // Where the sound was found to end before the part does, frames of the part; none as long as it was not.
  std::optional<std::int64_t> ended() const noexcept;
  std::int64_t damaged() const noexcept { return damaged_.load(); }
  // That could not be read on at all: its words, empty while it can.
  std::string trouble() const;

 private:
  void decode_ahead() noexcept;
  // Frames of the part from `place` on into block_; never none.
  std::size_t decode(std::int64_t place) noexcept;

  const std::unique_ptr<SoundTrack> track_;
  const std::size_t channels_;
  const SoundPart part_;
  const bool in_step_;
  const std::int64_t room_;

  mutable std::mutex mutex_;
  std::condition_variable rung_;  // for the decoder
  std::condition_variable filled_;
  std::vector<float> ring_;  // frame f is at f % room_
  std::int64_t begin_ = 0;   // frames [begin_, end_) are in the ring; none while the decoder is behind
  std::int64_t next_ = 0;    // to be read
  std::int64_t end_ = 0;
  std::int64_t jumps_ = 0;
  bool stopping_ = false;
  std::optional<std::int64_t> ended_;
  std::string trouble_;

  std::vector<float> block_;  // the decoder's
  std::atomic<std::int64_t> damaged_{0};
  std::thread decoder_;
};

}  // namespace cupola
