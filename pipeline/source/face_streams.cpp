// What the streams of a set of faces have in common.
// SPDX-License-Identifier: MIT
#include "pipeline/source/face_streams.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "pipeline/frame/error.h"

namespace cupola {

std::vector<Size> FaceStreams::face_sizes() const {
  std::vector<Size> sizes;
  for (const FacePlace& place : places) sizes.push_back(place.size);
  return sizes;
}

PixelFormat FaceStreams::format() const {
  const bool deep = std::ranges::any_of(
      streams, [](const auto& pictures) { return pictures->format() == PixelFormat::kRgbPlanar16; });
  return deep ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8;
}

std::optional<std::int64_t> FaceStreams::length() const {
  const PictureStream* measure = nullptr;
  for (const auto& pictures : streams) {
    const auto length = pictures->length();
    if (!length) continue;
    if (measure != nullptr && *length != *measure->length()) {
      throw InputError(fmt::format("{}: has {} frames, but {} has {}; expected as many", pictures->name(),
                                   *length, measure->name(), *measure->length()));
    }
    measure = pictures.get();
  }
  return measure ? measure->length() : std::nullopt;
}

std::vector<RowRange> FaceStreams::needed_rows(std::span<const NeededRegion> needed) const {
  std::vector<RowRange> rows(streams.size(), {std::numeric_limits<int>::max(), 0});
  for (std::size_t i = 0; i < places.size(); ++i) {
    RowRange& of_stream = rows[places[i].stream];
    for (std::size_t y = 0; y < needed[i].rows.size(); ++y) {
      if (needed[i].rows[y].empty()) continue;
      of_stream.first = std::min(of_stream.first, places[i].y + static_cast<int>(y));
      of_stream.last = std::max(of_stream.last, places[i].y + static_cast<int>(y) + 1);
    }
  }
  return rows;
}

FileCounts& FileCounts::operator+=(const FileCounts& other) {
  repeated += other.repeated;
  broken += other.broken;
  late += other.late;
  sought += other.sought;
  decoded += other.decoded;
  decode_ns += other.decode_ns;
  longest_ns = std::max(longest_ns, other.longest_ns);
  bytes_ahead += other.bytes_ahead;
  return *this;
}

}  // namespace cupola
