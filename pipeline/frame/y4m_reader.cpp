// Y4M to RGB in integers.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/y4m_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

constexpr std::string_view kFrameLine = "FRAME\n";

}  // namespace

Y4mReader::Y4mReader(const std::filesystem::path& path) : file_(path, "a Y4M video"), name_(path.string()) {
  char start[kLongestY4mHeader];
  const auto count = static_cast<std::size_t>(std::min<std::int64_t>(file_.size(), kLongestY4mHeader));
  file_.read_at(0, start, count);
  header_ = parse_y4m_header({start, count}, name_);

  const std::int64_t each = static_cast<std::int64_t>(kFrameLine.size()) + header_.frame_bytes();
  const std::int64_t all = file_.size() - static_cast<std::int64_t>(header_.bytes);
  frames_ = all / each;
  const std::int64_t left = all % each;
  // A frame line with parameters would also upset the count, so the first one is looked at before it is
  // blamed.
  if (all > 0) {
    char line[kFrameLine.size() + 1] = {};
    const auto shown = std::min<std::int64_t>(all, kFrameLine.size());
    file_.read_at(static_cast<std::int64_t>(header_.bytes), line, static_cast<std::size_t>(shown));
    if (std::string_view(line) == "FRAME ") {
      throw InputError(
          fmt::format("{}: its frames have parameters of their own; expected a bare FRAME line", name_));
    }
  }
  if (frames_ == 0 || left != 0) {
    throw InputError(fmt::format("{}: the Y4M video ends within frame {}; expected {} bytes a frame", name_,
                                 frames_, header_.frame_bytes()));
  }
  const auto chroma_bytes = static_cast<std::size_t>(header_.chroma_bytes());
  luma_.resize(static_cast<std::size_t>(header_.luma_bytes()));
  for (auto& plane : chroma_) plane.resize(chroma_bytes);
  to_rgb_.emplace(header_);
}

void Y4mReader::read(std::int64_t frame, const MutableImage& into, RowRange rows) {
  if (into.size != header_.size) {
    throw InputError(fmt::format("{}: the video is {} x {}; expected {} x {}", name_, header_.size.width,
                                 header_.size.height, into.size.width, into.size.height));
  }
  if (frame < 0 || frame >= frames_) {
    throw InputError(fmt::format("{}: frame {} asked for; it has frames 0 to {}", name_, frame, frames_ - 1));
  }
  rows = rows.within(header_.size.height);
  if (rows.empty()) return;
  std::int64_t at = static_cast<std::int64_t>(header_.bytes) +
                    frame * (static_cast<std::int64_t>(kFrameLine.size()) + header_.frame_bytes());
  char line[kFrameLine.size()];
  file_.read_at(at, line, sizeof line);
  if (std::string_view(line, sizeof line) != kFrameLine) {
    throw InputError(fmt::format("{}: frame {} does not begin with a bare FRAME line", name_, frame));
  }
  at += static_cast<std::int64_t>(sizeof line);

  const auto fetch_rows = [&](std::vector<std::byte>& to, RowRange wanted, int width) {
    const std::int64_t row_bytes = std::int64_t{width} * header_.bytes_per_sample();
    file_.read_at(at + wanted.first * row_bytes, to.data(),
                  static_cast<std::size_t>((wanted.last - wanted.first) * row_bytes));
  };
  fetch_rows(luma_, rows, header_.size.width);
  at += header_.luma_bytes();
  const RowRange chroma_rows = to_rgb_->chroma_rows(rows);
  if (header_.colour) {
    for (auto& plane : chroma_) {
      fetch_rows(plane, chroma_rows, header_.chroma_width());
      at += header_.chroma_bytes();
    }
  }
  const auto stride = [&](int width) { return std::ptrdiff_t{width} * header_.bytes_per_sample(); };
  to_rgb_->convert({{{luma_.data(), stride(header_.size.width)},
                     {chroma_[0].data(), stride(header_.chroma_width())},
                     {chroma_[1].data(), stride(header_.chroma_width())}}},
                   rows, into);
}

}  // namespace cupola
