// Faces from files.
// SPDX-License-Identifier: MIT
#include "pipeline/source/file_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "pipeline/frame/error.h"
#include "pipeline/source/numbered_files.h"

namespace cupola {
namespace {

using Streams = std::vector<std::unique_ptr<PictureStream>>;

std::unique_ptr<FileSource> one_stream_a_view(Streams streams, WorkerPool* pool) {
  std::vector<FacePlace> places;
  for (std::size_t i = 0; i < streams.size(); ++i) places.push_back({i, 0, 0, streams[i]->size()});
  return std::make_unique<FileSource>(std::move(streams), std::move(places), pool);
}

}  // namespace

FileSource::FileSource(Streams streams, std::vector<FacePlace> places, WorkerPool* pool)
    : places_(std::move(places)), pool_(pool) {
  const PictureStream* measure = nullptr;
  for (auto& pictures : streams) {
    if (pictures->format() == PixelFormat::kRgbPlanar16) format_ = PixelFormat::kRgbPlanar16;
    if (const auto length = pictures->length()) {
      if (measure != nullptr && *length != *length_) {
        throw InputError(fmt::format("{}: has {} frames, but {} has {}; expected as many", pictures->name(),
                                     *length, measure->name(), *length_));
      }
      measure = pictures.get();
      length_ = length;
    }
    streams_.push_back({std::move(pictures), {}, {}, {}});
  }
}

std::vector<Size> FileSource::face_sizes() const {
  std::vector<Size> sizes;
  for (const FacePlace& place : places_) sizes.push_back(place.size);
  return sizes;
}

void FileSource::prepare(std::span<const NeededRegion> needed) {
  assert(needed.size() == places_.size());
  for (Stream& stream : streams_) stream.rows = {std::numeric_limits<int>::max(), 0};
  for (std::size_t i = 0; i < places_.size(); ++i) {
    RowRange& rows = streams_[places_[i].stream].rows;
    for (std::size_t y = 0; y < needed[i].rows.size(); ++y) {
      if (needed[i].rows[y].empty()) continue;
      rows.first = std::min(rows.first, places_[i].y + static_cast<int>(y));
      rows.last = std::max(rows.last, places_[i].y + static_cast<int>(y) + 1);
    }
  }
  for (Stream& stream : streams_) {
    stream.shown = ImageBuffer(format_, stream.pictures->size());
    if (stream.pictures->length()) stream.coming = ImageBuffer(format_, stream.pictures->size());
  }
  auto read_still = [&](int i) {
    Stream& stream = streams_[static_cast<std::size_t>(i)];
    if (stream.coming.empty()) read(stream, 0, stream.shown);
  };
  const int count = static_cast<int>(streams_.size());
  if (pool_ != nullptr) {
    pool_->run(count, read_still);
  } else {
    for (int i = 0; i < count; ++i) read_still(i);
  }
}

void FileSource::read(Stream& stream, std::int64_t frame, ImageBuffer& into) {
  const int height = stream.pictures->size().height;
  const int rows = stream.rows.empty() ? 0 : stream.rows.last - stream.rows.first;
  if (rows > 0) stream.pictures->read(frame, stream.rows, into.pixels());
  rows_skipped_ += height - rows;
}

void FileSource::read_frame(std::int64_t frame) {
  auto read_coming = [&](int i) {
    Stream& stream = streams_[static_cast<std::size_t>(i)];
    if (!stream.coming.empty()) read(stream, frame, stream.coming);
  };
  const int count = static_cast<int>(streams_.size());
  if (pool_ != nullptr && count > 1) {
    pool_->run(count, read_coming);
  } else {
    for (int i = 0; i < count; ++i) read_coming(i);
  }
  for (Stream& stream : streams_) {
    if (!stream.coming.empty()) std::swap(stream.shown, stream.coming);
  }
}

void FileSource::show(FaceSet& faces) const {
  faces.faces.resize(places_.size());
  faces.frame = std::max<std::int64_t>(frame_, 0);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const FacePlace& place = places_[i];
    faces.faces[i] = part_of(streams_[place.stream].shown.pixels(), place.x, place.y, place.size);
  }
}

Fetch FileSource::fetch(std::int64_t frame, FaceSet& faces) noexcept {
  Fetch result = Fetch::kNew;
  try {
    if (frame < 0 || (length_ && frame >= *length_)) {
      result = Fetch::kEnd;
    } else if (frame_ >= 0 && (!length_ || frame == frame_)) {
      result = Fetch::kUnchanged;
      frame_ = frame;
    } else {
      if (length_) read_frame(frame);
      frame_ = frame;
    }
  } catch (const std::exception& error) {
    last_error_ = error.what();
    result = Fetch::kFailed;
  }
  show(faces);
  return result;
}

std::unique_ptr<FileSource> open_stills(std::span<const std::filesystem::path> files, WorkerPool* pool) {
  Streams streams;
  for (const auto& file : files) {
    streams.push_back(open_still_or_video(file));
    if (streams.back()->length())
      throw InputError(fmt::format("{}: is a video; expected a still", file.string()));
  }
  return one_stream_a_view(std::move(streams), pool);
}

std::unique_ptr<FileSource> open_videos(std::span<const std::filesystem::path> files, WorkerPool* pool) {
  Streams streams;
  for (const auto& file : files) {
    streams.push_back(open_still_or_video(file));
    if (!streams.back()->length())
      throw InputError(fmt::format("{}: is a still; expected a Y4M video", file.string()));
  }
  return one_stream_a_view(std::move(streams), pool);
}

std::vector<std::filesystem::path> files_of_views(std::string_view pattern,
                                                  std::span<const std::string> views) {
  if (views.size() > 1 && !has_view(pattern)) {
    throw InputError(fmt::format("{}: expected {{view}} or {{letter}} in it, for there are {} views", pattern,
                                 views.size()));
  }
  std::vector<std::filesystem::path> files;
  for (const std::string& view : views) files.emplace_back(pattern_of_view(pattern, view));
  return files;
}

std::unique_ptr<FileSource> open_sequence(const std::string& pattern, std::span<const std::string> views,
                                          SequencePart part, WorkerPool* pool) {
  std::error_code error;
  const bool folder = std::filesystem::is_directory(pattern, error);
  std::vector<std::string> patterns;
  for (const auto& file : files_of_views(folder ? find_pattern(pattern, views) : pattern, views))
    patterns.push_back(file);
  const NumberRange numbers = find_numbers(patterns, part.in, part.out);
  Streams streams;
  for (const std::string& of_view : patterns)
    streams.push_back(open_numbered(of_view, numbers.first, numbers.last));
  return one_stream_a_view(std::move(streams), pool);
}

std::unique_ptr<FileSource> open_atlas(const std::string& file, const AtlasLayout& layout,
                                       std::span<const std::string> views, SequencePart part) {
  Streams streams;
  if (has_number(file)) {
    const NumberRange numbers = find_numbers(std::span(&file, 1), part.in, part.out);
    streams.push_back(open_numbered(file, numbers.first, numbers.last));
  } else {
    streams.push_back(open_still_or_video(file));
  }
  const Size size = streams.front()->size();
  if (layout.columns < 1 || layout.rows < 1 || size.width % layout.columns != 0 ||
      size.height % layout.rows != 0) {
    throw InputError(fmt::format("{}: {} x {} pixels do not divide into {} columns and {} rows of faces",
                                 file, size.width, size.height, layout.columns, layout.rows));
  }
  if (layout.faces.size() >
      static_cast<std::size_t>(layout.columns) * static_cast<std::size_t>(layout.rows)) {
    throw InputError(fmt::format("{}: {} faces named; expected at most {} x {}", file, layout.faces.size(),
                                 layout.columns, layout.rows));
  }
  const Size face{size.width / layout.columns, size.height / layout.rows};
  std::vector<FacePlace> places;
  for (const std::string& view : views) {
    const auto found = std::ranges::find(layout.faces, view);
    if (found == layout.faces.end() || std::ranges::count(layout.faces, view) > 1) {
      throw InputError(fmt::format("{}: the atlas has {} for view {}; its faces are {}", file,
                                   found == layout.faces.end() ? "no face" : "several faces", view,
                                   fmt::join(layout.faces, ", ")));
    }
    const int cell = static_cast<int>(found - layout.faces.begin());
    places.push_back({0, cell % layout.columns * face.width, cell / layout.columns * face.height, face});
  }
  return std::make_unique<FileSource>(std::move(streams), std::move(places), nullptr);
}

}  // namespace cupola
