// One picture in files, still or moving: a still, numbered stills, or a Y4M video.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

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
  // Fills at least the rows `rows` of `into`, which has the stream's size and any planar format; throws
  // InputError, and then `into` may be partly written.
  virtual void read(std::int64_t frame, RowRange rows, const MutableImage& into) = 0;
};

// All throw InputError. A Y4M is known by its first bytes, whatever its name.
std::unique_ptr<PictureStream> open_still_or_video(const std::filesystem::path& path);
// Frame 0 is file number `first`, in a pattern without view (numbered_files.h). Takes size and format from
// that file.
std::unique_ptr<PictureStream> open_numbered(const std::string& pattern, std::int64_t first,
                                             std::int64_t last);

}  // namespace cupola
