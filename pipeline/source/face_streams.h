// Where the views' faces lie in the pictures of some streams, which run in lockstep.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/optics/needed_region.h"
#include "pipeline/source/face_source.h"
#include "pipeline/source/picture_stream.h"

namespace cupola {

// Where a view's face is: a rectangle of one of the streams.
struct FacePlace {
  std::size_t stream = 0;
  int x = 0;  // pixels
  int y = 0;
  Size size;
};

struct FaceStreams {
  std::vector<std::unique_ptr<PictureStream>> streams;
  std::vector<FacePlace> places;  // in the rig's order of views

  std::vector<Size> face_sizes() const;
  // 16 bits when one of the streams has 16.
  PixelFormat format() const;
  // Frames of the streams that move; none when all stand. Throws InputError when they differ.
  std::optional<std::int64_t> length() const;
  // Of each stream the rows that any of its faces needs; `needed` has one region a place.
  std::vector<RowRange> needed_rows(std::span<const NeededRegion> needed) const;
};

// Files that are read frame after frame, and what happened to them so far.
struct FileCounts {
  std::int64_t repeated = 0;     // pictures that were not decoded, being to the byte those before
  std::int64_t broken = 0;       // frames that were missing or damaged
  std::int64_t late = 0;         // frames that were not decoded when they were due
  std::int64_t sought = 0;       // of frames not decoded: the first ones after a jump, which nobody foresaw
  std::int64_t decoded = 0;      // frames
  std::int64_t decode_ns = 0;    // all of them together
  std::int64_t longest_ns = 0;   // the one that took longest
  std::int64_t bytes_ahead = 0;  // memory of the pictures decoded ahead, all of it

  FileCounts& operator+=(const FileCounts& other);
};

// Frames that are decoded and not fetched yet.
struct FileQueue {
  int frames = 0;
  int most = 0;  // 0: there is no queue
};

class FileFaces : public FaceSource {
 public:
  // Does not allocate.
  virtual FileCounts counts() const noexcept = 0;
  virtual FileQueue queue() const noexcept { return {}; }
  // Why the last fetch failed; valid until the next one.
  virtual const char* trouble() const noexcept = 0;
  // The frames that come next are the first ones: this is not played now. What was fetched last stands.
  virtual void rest() noexcept {}
};

}  // namespace cupola
