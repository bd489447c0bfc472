// The three kinds of picture stream.
// SPDX-License-Identifier: MIT
#include "pipeline/source/picture_stream.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "pipeline/frame/still.h"
#include "pipeline/frame/y4m_reader.h"
#include "pipeline/source/numbered_files.h"

namespace cupola {
namespace {

class Still final : public PictureStream {
 public:
  explicit Still(std::filesystem::path path) : path_(std::move(path)), info_(probe_still(path_)) {}
  Size size() const override { return info_.size; }
  PixelFormat format() const override { return info_.format; }
  std::optional<std::int64_t> length() const override { return std::nullopt; }
  std::string name() const override { return path_.string(); }
  void read(std::int64_t, RowRange rows, const MutableImage& into) override {
    FileBytes memory;  // read once: not worth keeping
    read_still_into(path_, into, rows, memory);
  }

 private:
  std::filesystem::path path_;
  StillInfo info_;
};

class Numbered final : public PictureStream {
 public:
  Numbered(std::string pattern, std::int64_t first, std::int64_t last)
      : pattern_(std::move(pattern)),
        first_(first),
        last_(last),
        info_(probe_still(std::filesystem::path(numbered_file(pattern_, first)))) {}
  Size size() const override { return info_.size; }
  PixelFormat format() const override { return info_.format; }
  std::optional<std::int64_t> length() const override { return last_ - first_ + 1; }
  std::string name() const override { return pattern_; }
  void read(std::int64_t frame, RowRange rows, const MutableImage& into) override {
    read_still_into(numbered_file(pattern_, first_ + frame), into, rows, memory_);
  }

 private:
  std::string pattern_;
  std::int64_t first_;
  std::int64_t last_;
  StillInfo info_;
  FileBytes memory_;
};

class Video final : public PictureStream {
 public:
  explicit Video(const std::filesystem::path& path) : path_(path), reader_(path) {}
  Size size() const override { return reader_.size(); }
  PixelFormat format() const override { return reader_.format(); }
  std::optional<std::int64_t> length() const override { return reader_.frames(); }
  std::string name() const override { return path_.string(); }
  void read(std::int64_t frame, RowRange rows, const MutableImage& into) override {
    reader_.read(frame, into, rows);
  }

 private:
  std::filesystem::path path_;
  Y4mReader reader_;
};

bool is_y4m(const std::filesystem::path& path) {
  constexpr std::string_view kMagic = "YUV4MPEG2";
  const RegularFile file(path, "a PNG, JPEG or TIFF picture, or a Y4M video");
  char start[kMagic.size()];
  if (file.size() < static_cast<std::int64_t>(sizeof start)) return false;
  file.read_at(0, start, sizeof start);
  return std::string_view(start, sizeof start) == kMagic;
}

}  // namespace

std::unique_ptr<PictureStream> open_still_or_video(const std::filesystem::path& path) {
  if (is_y4m(path)) return std::make_unique<Video>(path);
  return std::make_unique<Still>(path);
}

std::unique_ptr<PictureStream> open_numbered(const std::string& pattern, std::int64_t first,
                                             std::int64_t last) {
  return std::make_unique<Numbered>(pattern, first, last);
}

}  // namespace cupola
