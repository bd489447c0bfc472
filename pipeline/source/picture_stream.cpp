// The three kinds of picture stream.
// SPDX-License-Identifier: MIT
#include "pipeline/source/picture_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>

#include "pipeline/frame/checksum.h"
#include "pipeline/frame/error.h"
#include "pipeline/frame/still.h"
#include "pipeline/frame/y4m_reader.h"
#include "pipeline/source/numbered_files.h"
#include "pipeline/source/video_stream.h"

namespace cupola {
namespace {

constexpr const char* kStills = "a PNG, JPEG, TIFF or EXR picture";

class Still final : public PictureStream {
 public:
  explicit Still(std::filesystem::path path) : path_(std::move(path)), info_(probe_still(path_)) {}
  Size size() const override { return info_.size; }
  PixelFormat format() const override { return info_.format; }
  std::optional<std::int64_t> length() const override { return std::nullopt; }
  std::string name() const override { return path_.string(); }
  std::uint64_t stamp() const override { return stamp_of(path_); }
  bool read(std::int64_t, RowRange rows, const MutableImage& into, bool) override {
    FileBytes memory;  // read once: not worth keeping
    read_still_into(path_, into, rows, memory);
    return true;
  }

 private:
  std::filesystem::path path_;
  StillInfo info_;
};

// The size as probe_still has it, by the file's beginning where that is enough.
StillInfo probe_header(const std::filesystem::path& path) {
  constexpr std::int64_t kEnough = 32768;  // bytes
  const RegularFile file(path, kStills);
  if (file.size() > kEnough) {
    FileBytes start(kEnough);
    file.read_at(0, start.data(), start.size());
    // A PNG is looked at to its end otherwise.
    constexpr std::string_view kPng("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
    const std::string_view text(reinterpret_cast<const char*>(start.data()), start.size());
    const auto number = [&](std::size_t at) {
      int value = 0;
      for (std::size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<int>(start[i]);
      return value;
    };
    if (text.starts_with(kPng) && start[16] == std::byte{} && start[20] == std::byte{})
      return {{number(16), number(20)}, PixelFormat::kRgbPlanar8};
    try {
      return probe_still(start, path.string());
    } catch (const InputError&) {  // the header goes on, or lies at the end
    }
  }
  return probe_still(path);
}

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
  std::uint64_t stamp() const override {
    std::uint64_t stamp = 0;
    for (std::int64_t number = first_; number <= last_; ++number)
      stamp = stamp_of(numbered_file(pattern_, number), stamp);
    return stamp;
  }
  std::vector<std::string> faults() const override {
    std::vector<std::string> faults;
    for (std::int64_t number = first_; number <= last_; ++number) {
      const std::string file = numbered_file(pattern_, number);
      try {
        const Size size = probe_header(file).size;
        if (size == info_.size) continue;
        faults.push_back(fmt::format("{}: the picture is {} x {}; expected {} x {}, as the first one has",
                                     file, size.width, size.height, info_.size.width, info_.size.height));
      } catch (const InputError& error) {
        faults.emplace_back(error.what());
      }
    }
    return faults;
  }
  bool read(std::int64_t frame, RowRange rows, const MutableImage& into, bool may_repeat) override {
    const std::string file = numbered_file(pattern_, first_ + frame);
    read_file(file, kStills, bytes_);
    if (may_repeat && bytes_.size() == before_.size() &&
        std::memcmp(bytes_.data(), before_.data(), bytes_.size()) == 0) {
      return false;
    }
    decode_still(bytes_, file, into, rows);
    std::swap(bytes_, before_);
    return true;
  }

 private:
  std::string pattern_;
  std::int64_t first_;
  std::int64_t last_;
  StillInfo info_;
  FileBytes bytes_;
  FileBytes before_;  // of the file decoded last
};

class Video final : public PictureStream {
 public:
  explicit Video(const std::filesystem::path& path) : path_(path), reader_(path) {}
  Size size() const override { return reader_.size(); }
  PixelFormat format() const override { return reader_.format(); }
  std::optional<std::int64_t> length() const override { return reader_.frames(); }
  double rate() const override {
    const FrameRate rate = reader_.header().rate;
    return static_cast<double>(rate.numerator) / static_cast<double>(rate.denominator);
  }
  std::string name() const override { return path_.string(); }
  std::uint64_t stamp() const override { return stamp_of(path_); }
  bool read(std::int64_t frame, RowRange rows, const MutableImage& into, bool) override {
    reader_.read(frame, into, rows);
    return true;
  }

 private:
  std::filesystem::path path_;
  Y4mReader reader_;
};

bool is_y4m(const std::filesystem::path& path, const char* expected) {
  constexpr std::string_view kMagic = "YUV4MPEG2";
  const RegularFile file(path, expected);
  char start[kMagic.size()];
  if (file.size() < static_cast<std::int64_t>(sizeof start)) return false;
  file.read_at(0, start, sizeof start);
  return std::string_view(start, sizeof start) == kMagic;
}

}  // namespace

std::uint64_t stamp_of(const std::filesystem::path& file, std::uint64_t seed) {
  std::error_code error;
  const std::uint64_t facts[] = {
      static_cast<std::uint64_t>(std::filesystem::file_size(file, error)),
      static_cast<std::uint64_t>(std::filesystem::last_write_time(file, error).time_since_epoch().count())};
  return checksum(std::as_bytes(std::span(facts)), seed);
}

std::unique_ptr<PictureStream> open_still_or_video(const std::filesystem::path& path) {
  if (is_y4m(path, "a PNG, JPEG, TIFF or EXR picture, or a Y4M video")) return std::make_unique<Video>(path);
  return std::make_unique<Still>(path);
}

std::unique_ptr<PictureStream> open_moving(const std::filesystem::path& path) {
  if (is_y4m(path, "a video")) return std::make_unique<Video>(path);
  return open_video(path);
}

std::unique_ptr<PictureStream> open_numbered(const std::string& pattern, std::int64_t first,
                                             std::int64_t last) {
  return std::make_unique<Numbered>(pattern, first, last);
}

}  // namespace cupola
