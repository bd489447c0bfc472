// Rows are copies of one long row, each from two texels further on than the one above.
// SPDX-License-Identifier: MIT
#include "hal/camera/fake_picture.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "hal/camera/camera_planes.h"
#include "hal/camera/fake_jpeg.h"

namespace cupola {

namespace {

constexpr int kSlope = 256;  // texels from dark to bright
constexpr int kCameraBits = 8;
constexpr int kSequenceBits = 32;
constexpr std::uint8_t kDark = 16;
constexpr std::uint8_t kBright = 235;

// How a format's first plane holds grey: texel x has it from byte `first` + x * `step`, `count` bytes long.
struct GreyBytes {
  std::size_t first = 0;
  std::size_t step = 1;
  std::size_t count = 1;
};

GreyBytes grey_bytes(CameraFormat format) {
  switch (format) {
    case CameraFormat::kYuyv:
      return {0, 2, 1};
    case CameraFormat::kUyvy:
    case CameraFormat::kP010:
      return {1, 2, 1};
    case CameraFormat::kRgb24:
    case CameraFormat::kBgr24:
      return {0, 3, 3};
    case CameraFormat::kXrgb32:
      return {0, 4, 3};
    default:
      return {0, 1, 1};
  }
}

std::uint64_t bits_of(int camera, std::uint32_t sequence) {
  return std::uint64_t{sequence} << kCameraBits | static_cast<std::uint8_t>(camera);
}

}  // namespace

std::optional<PictureStamp> read_stamp(const CameraFrame& frame) {
  const CameraPlane& plane = frame.planes[0];
  std::uint64_t bits = 0;
  if (frame.format == CameraFormat::kMjpeg) {
    if (!read_jpeg_note({plane.data, plane.bytes}, bits)) return std::nullopt;
  } else {
    if (frame.width < FakePicture::kLeastWidth || !plane.data) return std::nullopt;
    const GreyBytes grey = grey_bytes(frame.format);
    for (int x = 0; x < kCameraBits + kSequenceBits; ++x) {
      const std::uint8_t value = plane.data[grey.first + static_cast<std::size_t>(x) * grey.step];
      if (value != kDark && value != kBright) return std::nullopt;
      bits |= std::uint64_t{value == kBright} << x;
    }
  }
  return PictureStamp{static_cast<int>(bits & 0xff), static_cast<std::uint32_t>(bits >> kCameraBits)};
}

FakePicture::FakePicture(CameraFormat format, int width, int height, int camera)
    : format_(format), width_(width), height_(height), camera_(camera) {
  if (width < kLeastWidth || height < 1 || width > 65535 || height > 65535) {
    throw std::runtime_error("fake picture: expected 40 to 65535 by 1 to 65535 texels");
  }
  if (format == CameraFormat::kMjpeg) {
    bytes_ = jpeg_capacity(width, height);
    return;
  }
  for (int p = 0; p < plane_count(format); ++p) {
    const PlaneShape shape = plane_shape(format, p, width, height);
    bytes_ += static_cast<std::size_t>(shape.row_bytes * shape.rows);
  }
  const GreyBytes grey = grey_bytes(format);
  texel_bytes_ = grey.step;
  row_bytes_ = static_cast<std::size_t>(plane_shape(format, 0, width, height).row_bytes);
  slope_.assign(row_bytes_ + kSlope * texel_bytes_, static_cast<std::uint8_t>(128 + 8 * (camera % 8)));
  for (std::size_t x = 0; grey.first + x * grey.step + grey.count <= slope_.size(); ++x) {
    const auto value = static_cast<std::uint8_t>(kDark + (kBright - kDark) * (x % kSlope) / (kSlope - 1));
    std::memset(slope_.data() + grey.first + x * grey.step, value, grey.count);
  }
}

void FakePicture::prepare(std::span<std::uint8_t> memory) const {
  std::fill(memory.begin(), memory.end(), static_cast<std::uint8_t>(128 + 8 * (camera_ % 8)));
}

std::size_t FakePicture::draw(std::span<std::uint8_t> memory, std::uint32_t sequence) const {
  const std::uint64_t bits = bits_of(camera_, sequence);
  if (format_ == CameraFormat::kMjpeg) return write_jpeg(memory, width_, height_, sequence, bits);
  std::uint8_t* row = memory.data();
  for (std::uint32_t y = 0; y < static_cast<std::uint32_t>(height_); ++y, row += row_bytes_) {
    const std::size_t shift = 2 * ((y + sequence) % (kSlope / 2));
    std::memcpy(row, slope_.data() + shift * texel_bytes_, row_bytes_);
  }
  const GreyBytes grey = grey_bytes(format_);
  std::uint8_t* texel = memory.data() + grey.first;
  for (int x = 0; x < kCameraBits + kSequenceBits; ++x, texel += grey.step) {
    std::memset(texel, (bits >> x & 1) != 0 ? kBright : kDark, grey.count);
  }
  return bytes_;
}

void FakePicture::describe(const std::uint8_t* memory, std::size_t used, CameraFrame& frame) const {
  frame.format = format_;
  frame.width = width_;
  frame.height = height_;
  frame.planes = {};
  if (format_ == CameraFormat::kMjpeg) {
    frame.planes[0] = {memory, 0, used, -1, 0};
    return;
  }
  for (int p = 0; p < plane_count(format_); ++p) {
    const PlaneShape shape = plane_shape(format_, p, width_, height_);
    const auto bytes = static_cast<std::size_t>(shape.row_bytes * shape.rows);
    frame.planes[static_cast<std::size_t>(p)] = {memory, shape.row_bytes, bytes, -1, 0};
    memory += bytes;
  }
}

}  // namespace cupola
