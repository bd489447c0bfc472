// Pictures in memory: borrowed views of planes, and the buffer that owns them.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <type_traits>

namespace cupola {

struct Size {
  int width = 0;   // pixels
  int height = 0;  // pixels
  friend bool operator==(const Size&, const Size&) = default;
};

// Rows run top to bottom. Samples of 16 bits are in the machine's byte order.
enum class PixelFormat : std::uint8_t {
  kRgbPlanar8,   // planes R, G, B; what faces are in and what the warp works on
  kRgbPlanar16,  // the same with 16 bits a sample
  kRgb8,         // one plane, bytes R G B R G B ...
  kRgb16,        // one plane, 16 bits a sample
  kXrgb8888,     // one plane, little-endian 32-bit words 0xffRRGGBB, as KMS and windows take them
};

constexpr int plane_count(PixelFormat format) {
  return format == PixelFormat::kRgbPlanar8 || format == PixelFormat::kRgbPlanar16 ? 3 : 1;
}

constexpr int sample_bytes(PixelFormat format) {
  return format == PixelFormat::kRgbPlanar16 || format == PixelFormat::kRgb16 ? 2 : 1;
}

// Bytes from one pixel to the next within a plane.
constexpr int pixel_step(PixelFormat format) {
  switch (format) {
    case PixelFormat::kRgbPlanar8:
      return 1;
    case PixelFormat::kRgbPlanar16:
      return 2;
    case PixelFormat::kRgb8:
      return 3;
    case PixelFormat::kRgb16:
      return 6;
    case PixelFormat::kXrgb8888:
      return 4;
  }
  return 0;
}

template <class Byte>
struct Plane {
  Byte* data = nullptr;
  std::ptrdiff_t stride = 0;  // bytes from one row to the next
  Byte* row(int y) const { return data + y * stride; }
};

// A picture somewhere in memory, borrowed: valid as long as whoever owns the memory says.
template <class Byte>
struct BasicImage {
  PixelFormat format = PixelFormat::kRgbPlanar8;
  Size size;
  std::array<Plane<Byte>, 3> planes;

  // What may be written may be read.
  template <class Other>
  requires(!std::is_same_v<Other, Byte> && std::is_same_v<Other, const Byte>) operator BasicImage<Other>()
      const {
    BasicImage<Other> view{format, size, {}};
    for (std::size_t p = 0; p < 3; ++p) view.planes[p] = {planes[p].data, planes[p].stride};
    return view;
  }

  // Row `y` of plane `p` as samples of the format's width.
  template <class Sample>
  auto samples(int p, int y) const {
    if constexpr (std::is_const_v<Byte>) {
      return reinterpret_cast<const Sample*>(planes[p].row(y));
    } else {
      return reinterpret_cast<Sample*>(planes[p].row(y));
    }
  }
};
using Image = BasicImage<const std::byte>;
using MutableImage = BasicImage<std::byte>;

inline Image as_const(const MutableImage& image) {
  return image;
}

// The part of `image` whose top-left pixel is (x, y); nothing is copied.
template <class Byte>
BasicImage<Byte> part_of(const BasicImage<Byte>& image, int x, int y, Size size) {
  BasicImage<Byte> part{image.format, size, image.planes};
  for (std::size_t p = 0; p < static_cast<std::size_t>(plane_count(image.format)); ++p)
    part.planes[p].data = image.planes[p].row(y) + std::ptrdiff_t{x} * pixel_step(image.format);
  return part;
}
template <class Byte>
BasicImage<Byte> row_of(const BasicImage<Byte>& image, int y) {
  return part_of(image, 0, y, {image.size.width, 1});
}

// Owns the memory of one picture, all zero at first. Rows begin on 64-byte boundaries.
class ImageBuffer {
 public:
  ImageBuffer() = default;
  ImageBuffer(PixelFormat format, Size size);  // sides 1 to 65,535; throws std::bad_alloc

  bool empty() const { return memory_ == nullptr; }
  PixelFormat format() const { return view_.format; }
  Size size() const { return view_.size; }
  const MutableImage& pixels() { return view_; }
  Image pixels() const { return as_const(view_); }
  std::size_t bytes() const { return bytes_; }

 private:
  struct Release {
    void operator()(std::byte* memory) const { ::operator delete (memory, std::align_val_t{64}); }
  };
  std::unique_ptr<std::byte, Release> memory_;
  std::size_t bytes_ = 0;
  MutableImage view_;
};

// Copies between any two formats of equal size; 16 bits become 8 by rounding to nearest, 8 become 16 by
// x * 257. `from` and `to` must not overlap.
void convert(const Image& from, const MutableImage& to);

}  // namespace cupola
