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
#include <utility>
#include <vector>

#include "pipeline/parallel/worker_pool.h"
#include "pipeline/source/face_streams.h"

namespace cupola {

// Streams run in lockstep, and a frame is taken whole or not at all: when one picture of it is missing or
// damaged the faces of the last good frame stand, black before there was one. Pictures that never change are
// read in prepare(). A stream of which nothing is needed is not read. Frames are decoded into a second set of
// buffers and compared with the first: what differs is told, and a frame without a difference is kUnchanged.
// A numbered file that is to the byte the one before is not even decoded.
class FileSource final : public FileFaces {
 public:
  // Throws InputError when lengths differ. `pool`, when given, decodes the streams in parallel; it is
  // borrowed for the source's life and must be idle whenever prepare or fetch is called.
  FileSource(FaceStreams faces, WorkerPool* pool);

  std::vector<Size> face_sizes() const override { return faces_.face_sizes(); }
  PixelFormat format() const override { return format_; }
  std::optional<std::int64_t> length() const override { return length_; }
  void prepare(std::span<const NeededRegion> needed) override;
  Fetch fetch(std::int64_t frame, FaceSet& faces) noexcept override;

  const char* trouble() const noexcept override { return last_error_.c_str(); }
  FileCounts counts() const noexcept override { return {.repeated = pictures_repeated_}; }
  double rate() const { return faces_.streams.front()->rate(); }  // frames a second; 0: the files do not say
  std::vector<std::string> faults() const {
    std::vector<std::string> all;
    for (const auto& pictures : faces_.streams) {
      for (std::string& fault : pictures->faults()) all.push_back(std::move(fault));
    }
    return all;
  }
  // Of all files: others when one of them was written anew.
  std::uint64_t stamp() const {
    std::uint64_t sum = 0;
    for (const auto& pictures : faces_.streams) sum = 31 * sum + pictures->stamp();
    return sum;
  }
  // For who reads them otherwise; nothing else may be called afterwards.
  FaceStreams streams() && { return std::move(faces_); }
  std::int64_t rows_skipped() const {
    return rows_skipped_.load();
  }  // rows of pictures not asked for, in all

 private:
  struct Stream {
    PictureStream* pictures;
    RowRange rows;  // needed by any of its faces
    ImageBuffer shown;
    ImageBuffer coming;    // empty for a picture that never changes
    bool repeats = false;  // the coming picture is the one shown, which `coming` does not hold
  };
  // Gives false where the picture repeats the one before.
  bool read(Stream& stream, std::int64_t frame, ImageBuffer& into);
  void read_frame(std::int64_t frame);
  void compare_faces();  // shown and coming
  void show(FaceSet& faces) const;

  FaceStreams faces_;
  std::vector<Stream> streams_;
  std::vector<NeededRegion> needed_;   // one a place, as is
  std::vector<ChangedCells> changed_;  // by the last frame
  WorkerPool* pool_;
  PixelFormat format_ = PixelFormat::kRgbPlanar8;
  std::optional<std::int64_t> length_;
  std::int64_t frame_ = -1;  // shown; -1: none yet
  bool whole_ = false;       // what the streams read last is what is shown
  std::atomic<std::int64_t> rows_skipped_{0};
  std::int64_t pictures_repeated_ = 0;
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
  int padding = 0;                 // texels on every side of a cell that are not the face's
};
// `file` is a still, a Y4M video, or a pattern with a number. Cells that are none of `views` are never used.
std::unique_ptr<FileSource> open_atlas(const std::string& file, const AtlasLayout& layout,
                                       std::span<const std::string> views, SequencePart part = {});

// Videos, Y4M or compressed: one with all faces, or one a view in lockstep.
std::unique_ptr<FileSource> open_video_atlas(const std::string& file, const AtlasLayout& layout,
                                             std::span<const std::string> views);
std::unique_ptr<FileSource> open_video_views(std::span<const std::filesystem::path> files);

}  // namespace cupola
