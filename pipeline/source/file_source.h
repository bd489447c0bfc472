// Faces from files: stills, numbered stills and Y4M videos, one a view or all in one picture.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/parallel/worker_pool.h"
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

// Streams run in lockstep, and a frame is taken whole or not at all: when one picture of it is missing or
// damaged the faces of the last good frame stand, black before there was one. Pictures that never change are
// read in prepare(). A stream of which nothing is needed is not read. Frames are decoded into a second set of
// buffers.
class FileSource final : public FaceSource {
 public:
  // `places` in the rig's order of views. Throws InputError when lengths differ. `pool`, when given, decodes
  // the streams in parallel; it is borrowed for the source's life and must be idle whenever prepare or fetch
  // is called.
  FileSource(std::vector<std::unique_ptr<PictureStream>> streams, std::vector<FacePlace> places,
             WorkerPool* pool);

  std::vector<Size> face_sizes() const override;
  PixelFormat format() const override { return format_; }
  std::optional<std::int64_t> length() const override { return length_; }
  void prepare(std::span<const NeededRegion> needed) override;
  Fetch fetch(std::int64_t frame, FaceSet& faces) noexcept override;

  std::string last_error() const { return last_error_; }  // of the fetch that failed last
  std::int64_t rows_skipped() const {
    return rows_skipped_.load();
  }  // rows of pictures not asked for, in all

 private:
  struct Stream {
    std::unique_ptr<PictureStream> pictures;
    RowRange rows;  // needed by any of its faces
    ImageBuffer shown;
    ImageBuffer coming;  // empty for a picture that never changes
  };
  void read(Stream& stream, std::int64_t frame, ImageBuffer& into);
  void read_frame(std::int64_t frame);
  void show(FaceSet& faces) const;

  std::vector<Stream> streams_;
  std::vector<FacePlace> places_;
  WorkerPool* pool_;
  PixelFormat format_ = PixelFormat::kRgbPlanar8;
  std::optional<std::int64_t> length_;
  std::int64_t frame_ = -1;  // shown; -1: none yet
  std::atomic<std::int64_t> rows_skipped_{0};
  std::string last_error_;
};

// All open_* throw InputError. `files` are in the rig's order of views.
std::unique_ptr<FileSource> open_stills(std::span<const std::filesystem::path> files,
                                        WorkerPool* pool = nullptr);
std::unique_ptr<FileSource> open_videos(std::span<const std::filesystem::path> files,
                                        WorkerPool* pool = nullptr);
// A path with {view} or {letter} for each view: files to give to open_stills or open_videos.
std::vector<std::filesystem::path> files_of_views(std::string_view pattern,
                                                  std::span<const std::string> views);

// File numbers, both inclusive; where missing, what the folder has.
struct SequencePart {
  std::optional<std::int64_t> in;
  std::optional<std::int64_t> out;
};
// `pattern` as numbered_files.h has it, or a folder.
std::unique_ptr<FileSource> open_sequence(const std::string& pattern, std::span<const std::string> views,
                                          SequencePart part = {}, WorkerPool* pool = nullptr);

// A picture that holds the faces side by side, row by row.
struct AtlasLayout {
  int columns = 1;
  int rows = 1;
  std::vector<std::string> faces;  // the views' names, left to right, then down; empty for a cell without use
};
// `file` is a still, a Y4M video, or a pattern with a number. Cells that are none of `views` are never used.
std::unique_ptr<FileSource> open_atlas(const std::string& file, const AtlasLayout& layout,
                                       std::span<const std::string> views, SequencePart part = {});

}  // namespace cupola
