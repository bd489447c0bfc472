// One picture in files, still or moving: a still, numbered stills, or a video.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/frame/row_range.h"

namespace cupola {

// One thread at a time; different streams may be read at once.
class PictureStream {
 public:
  virtual ~PictureStream() = default;
  virtual Size size() const = 0;
  virtual PixelFormat format() const = 0;                  // planar, as the file has it
  virtual std::optional<std::int64_t> length() const = 0;  // frames; none: one picture that never changes
  virtual std::string name() const = 0;                    // for messages
  virtual double rate() const { return 0.0; }              // frames a second; 0: it does not say
  // Of its files: others when one of them was written anew. May not throw.
  virtual std::uint64_t stamp() const { return 0; }
  // What the headers of its files, looked at all of them, say against read(); a line a file. The first file's
  // was looked at when it was opened.
  virtual std::vector<std::string> faults() const { return {}; }
  // Fills at least the rows `rows` of `into`, which has the stream's size and any planar format; throws
  // InputError, and then `into` may be partly written. With `may_repeat` it may give false instead, and leave
  // `into` alone, where the picture is to the byte that of the read before.
  virtual bool read(std::int64_t frame, RowRange rows, const MutableImage& into, bool may_repeat) = 0;
};

// Size and time of writing of the files, as one number.
std::uint64_t stamp_of(const std::filesystem::path& file, std::uint64_t seed = 0);

// All throw InputError. A Y4M is known by its first bytes, whatever its name.
std::unique_ptr<PictureStream> open_still_or_video(const std::filesystem::path& path);
// Y4M, or what open_video() takes.
std::unique_ptr<PictureStream> open_moving(const std::filesystem::path& path);
// Frame 0 is file number `first`, in a pattern without view (numbered_files.h). Takes size and format from
// that file.
std::unique_ptr<PictureStream> open_numbered(const std::string& pattern, std::int64_t first,
                                             std::int64_t last);

}  // namespace cupola
