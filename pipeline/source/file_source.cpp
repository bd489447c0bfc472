// Faces from files.
// SPDX-License-Identifier: MIT
#include "pipeline/source/file_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "pipeline/frame/error.h"
#include "pipeline/source/face_changes.h"
#include "pipeline/source/numbered_files.h"

namespace cupola {
namespace {

using Streams = std::vector<std::unique_ptr<PictureStream>>;

std::unique_ptr<FileSource> one_stream_a_view(Streams streams, WorkerPool* pool) {
  std::vector<FacePlace> places;
  for (std::size_t i = 0; i < streams.size(); ++i) places.push_back({i, 0, 0, streams[i]->size()});
  return std::make_unique<FileSource>(FaceStreams{std::move(streams), std::move(places)}, pool);
}

}  // namespace

FileSource::FileSource(FaceStreams faces, WorkerPool* pool)
    : faces_(std::move(faces)), pool_(pool), format_(faces_.format()), length_(faces_.length()) {
  for (auto& pictures : faces_.streams) streams_.push_back({pictures.get(), {}, {}, {}, false});
}

void FileSource::prepare(std::span<const NeededRegion> needed) {
  assert(needed.size() == faces_.places.size());
  needed_.assign(needed.begin(), needed.end());
  changed_.clear();
  for (const FacePlace& place : faces_.places) changed_.emplace_back(place.size);
  const std::vector<RowRange> rows = faces_.needed_rows(needed);
  for (std::size_t i = 0; i < streams_.size(); ++i) {
    Stream& stream = streams_[i];
    stream.rows = rows[i];
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

bool FileSource::read(Stream& stream, std::int64_t frame, ImageBuffer& into) {
  const int height = stream.pictures->size().height;
  const int rows = stream.rows.empty() ? 0 : stream.rows.last - stream.rows.first;
  rows_skipped_ += height - rows;
  return rows == 0 || stream.pictures->read(frame, stream.rows, into.pixels(), whole_);
}

void FileSource::read_frame(std::int64_t frame) {
  auto read_coming = [&](int i) {
    Stream& stream = streams_[static_cast<std::size_t>(i)];
    if (!stream.coming.empty()) stream.repeats = !read(stream, frame, stream.coming);
  };
  const int count = static_cast<int>(streams_.size());
  try {
    if (pool_ != nullptr && count > 1) {
      pool_->run(count, read_coming);
    } else {
      for (int i = 0; i < count; ++i) read_coming(i);
    }
  } catch (...) {
    whole_ = false;  // some streams went on, and their pictures are dropped
    throw;
  }
  whole_ = true;
  compare_faces();
  for (Stream& stream : streams_) {
    if (stream.repeats) {
      ++pictures_repeated_;
    } else if (!stream.coming.empty()) {
      std::swap(stream.shown, stream.coming);
    }
  }
}

void FileSource::compare_faces() {
  auto compare = [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    const FacePlace& place = faces_.places[at];
    Stream& stream = streams_[place.stream];
    changed_[at].clear();
    if (stream.coming.empty() || stream.repeats) return;
    add_changes(part_of(as_const(stream.shown.pixels()), place.x, place.y, place.size),
                part_of(as_const(stream.coming.pixels()), place.x, place.y, place.size), needed_[at],
                changed_[at]);
  };
  const int count = static_cast<int>(faces_.places.size());
  if (pool_ != nullptr && count > 1) {
    pool_->run(count, compare);
  } else {
    for (int i = 0; i < count; ++i) compare(i);
  }
}

void FileSource::show(FaceSet& faces) const {
  faces.faces.resize(faces_.places.size());
  faces.frame = std::max<std::int64_t>(frame_, 0);
  for (std::size_t i = 0; i < faces_.places.size(); ++i) {
    const FacePlace& place = faces_.places[i];
    faces.faces[i] = part_of(streams_[place.stream].shown.pixels(), place.x, place.y, place.size);
  }
}

Fetch FileSource::fetch(std::int64_t frame, FaceSet& faces) noexcept {
  Fetch result = Fetch::kNew;
  faces.changed = {};
  try {
    if (frame < 0 || (length_ && frame >= *length_)) {
      result = Fetch::kEnd;
    } else if (frame_ >= 0 && (!length_ || frame == frame_)) {
      result = Fetch::kUnchanged;
      frame_ = frame;
    } else {
      if (length_) read_frame(frame);
      if (frame_ >= 0) {
        faces.changed = changed_;
        const auto stands = [](const ChangedCells& changed) { return changed.count() == 0; };
        if (std::ranges::all_of(changed_, stands)) result = Fetch::kUnchanged;
      }
      frame_ = frame;
    }
  } catch (const std::exception& error) {
    last_error_ = error.what();
    result = Fetch::kFailed;
  }
  if (result == Fetch::kNew || result == Fetch::kUnchanged || faces.faces.empty()) show(faces);
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

namespace {

std::vector<FacePlace> places_in(Size size, const std::string& file, const AtlasLayout& layout,
                                 std::span<const std::string> views) {
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
  const Size cell{size.width / layout.columns, size.height / layout.rows};
  const Size face{cell.width - 2 * layout.padding, cell.height - 2 * layout.padding};
  if (face.width < 1 || face.height < 1) {
    throw InputError(fmt::format("{}: cells of {} x {} pixels leave nothing within a padding of {}", file,
                                 cell.width, cell.height, layout.padding));
  }
  std::vector<FacePlace> places;
  for (const std::string& view : views) {
    const auto found = std::ranges::find(layout.faces, view);
    if (found == layout.faces.end() || std::ranges::count(layout.faces, view) > 1) {
      throw InputError(fmt::format("{}: the atlas has {} for view {}; its faces are {}", file,
                                   found == layout.faces.end() ? "no face" : "several faces", view,
                                   fmt::join(layout.faces, ", ")));
    }
    const int at = static_cast<int>(found - layout.faces.begin());
    places.push_back({0, at % layout.columns * cell.width + layout.padding,
                      at / layout.columns * cell.height + layout.padding, face});
  }
  return places;
}

}  // namespace

std::unique_ptr<FileSource> open_atlas(const std::string& file, const AtlasLayout& layout,
                                       std::span<const std::string> views, SequencePart part) {
  Streams streams;
  if (has_number(file)) {
    const NumberRange numbers = find_numbers(std::span(&file, 1), part.in, part.out);
    streams.push_back(open_numbered(file, numbers.first, numbers.last));
  } else {
    streams.push_back(open_still_or_video(file));
  }
  std::vector<FacePlace> places = places_in(streams.front()->size(), file, layout, views);
  return std::make_unique<FileSource>(FaceStreams{std::move(streams), std::move(places)}, nullptr);
}

std::unique_ptr<FileSource> open_video_atlas(const std::string& file, const AtlasLayout& layout,
                                             std::span<const std::string> views) {
  Streams streams;
  streams.push_back(open_moving(file));
  std::vector<FacePlace> places = places_in(streams.front()->size(), file, layout, views);
  return std::make_unique<FileSource>(FaceStreams{std::move(streams), std::move(places)}, nullptr);
}

std::unique_ptr<FileSource> open_video_views(std::span<const std::filesystem::path> files) {
  Streams streams;
  for (const auto& file : files) streams.push_back(open_moving(file));
  return one_stream_a_view(std::move(streams), nullptr);
}

}  // namespace cupola
