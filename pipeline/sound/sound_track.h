// The sound of a file, frame by frame at the rate that is wanted.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace cupola {

// Frames are counted from the file's time 0, which for the sound of a video is its first picture's.
class SoundTrack {
 public:
  virtual ~SoundTrack() = default;
  virtual std::string name() const = 0;
  // Frames, as the file says; where it says nothing, none is known and 0.
  virtual std::int64_t length() const = 0;
  // Interleaved samples from frame `first` on into `into`, as many frames as it holds but at the track's end;
  // goes on cheaply where the last call ended. What cannot be decoded is silence and counted. Throws
  // InputError where one cannot get there.
  virtual std::size_t read(std::int64_t first, std::span<float> into) = 0;
  // Packets that could not be decoded so far.
  virtual std::int64_t damaged() const = 0;
  virtual int file_channels() const = 0;
};

// Any container with sound that FFmpeg's libraries read; `channels` 0: the file's own number. Throws
// InputError.
std::unique_ptr<SoundTrack> open_sound(const std::filesystem::path& path, int rate, int channels);

}  // namespace cupola
