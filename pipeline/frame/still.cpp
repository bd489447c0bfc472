// Stills: finding the format of a file, and what all formats share.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/still.h"

#include <fmt/format.h>

#include <string_view>

#include "pipeline/frame/error.h"
#include "pipeline/frame/still_formats.h"

namespace cupola {
namespace {

constexpr char kExpected[] = "a PNG, JPEG, TIFF or EXR picture";

enum class Kind { kPng, kJpeg, kTiff, kExr };

Kind kind_of(std::span<const std::byte> file, const std::string& name) {
  using namespace std::string_view_literals;
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (text.starts_with("\x89PNG\r\n\x1a\n"sv)) return Kind::kPng;
  if (text.starts_with("\xff\xd8\xff"sv)) return Kind::kJpeg;
  if (text.starts_with("\x76\x2f\x31\x01"sv)) return Kind::kExr;
  for (const std::string_view magic : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
    if (text.starts_with(magic)) return Kind::kTiff;
  }
  throw InputError(fmt::format("{}: not a picture that can be read; expected {}", name, kExpected));
}

}  // namespace

void check_size(const std::string& name, std::int64_t width, std::int64_t height) {
  if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide) {
    throw InputError(fmt::format("{}: the picture is {} x {}; expected sides of 1 to {}", name, width, height,
                                 kLargestSide));
  }
  if (width * height > kMostPixels) {
    throw InputError(fmt::format("{}: the picture is {} x {}; expected at most {} pixels", name, width,
                                 height, kMostPixels));
  }
}

void store_row(const void* samples, PixelFormat format, const MutableImage& into, int y) {
  Image from{format, {into.size.width, 1}, {}};
  from.planes[0] = {static_cast<const std::byte*>(samples), 0};
  convert(from, row_of(into, y));
}

StillInfo probe_still(std::span<const std::byte> file, const std::string& name) {
  switch (kind_of(file, name)) {
    case Kind::kPng:
      return probe_png(file, name);
    case Kind::kJpeg:
      return probe_jpeg(file, name);
    case Kind::kTiff:
      return probe_tiff(file, name);
    case Kind::kExr:
      return probe_exr(file, name);
  }
  return {};
}

StillInfo probe_still(const std::filesystem::path& path) {
  FileBytes file;
  read_file(path, kExpected, file);
  return probe_still(file, path.string());
}

int decode_still(std::span<const std::byte> file, const std::string& name, const MutableImage& into,
                 RowRange rows) {
  const Size size = probe_still(file, name).size;
  if (size != into.size) {
    throw InputError(fmt::format("{}: the picture is {} x {}; expected {} x {}", name, size.width,
                                 size.height, into.size.width, into.size.height));
  }
  rows = rows.within(size.height);
  if (rows.empty()) return size.height;
  switch (kind_of(file, name)) {
    case Kind::kPng:
      return read_png(file, name, into, rows);
    case Kind::kJpeg:
      return read_jpeg(file, name, into, rows);
    case Kind::kTiff:
      return read_tiff(file, name, into, rows);
    case Kind::kExr:
      return read_exr(file, name, into, rows);
  }
  return 0;
}

int read_still_into(const std::filesystem::path& path, const MutableImage& into, RowRange rows,
                    FileBytes& memory) {
  read_file(path, kExpected, memory);
  return decode_still(memory, path.string(), into, rows);
}

ImageBuffer read_still(const std::filesystem::path& path) {
  FileBytes file;
  read_file(path, kExpected, file);
  const StillInfo info = probe_still(file, path.string());
  ImageBuffer image(info.format, info.size);
  decode_still(file, path.string(), image.pixels());
  return image;
}

void write_still(const std::filesystem::path& path, const Image& image, StillFormat format) {
  format == StillFormat::kExr ? write_exr(path, image) : write_png(path, image);
}

}  // namespace cupola
