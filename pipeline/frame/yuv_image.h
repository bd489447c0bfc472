// YUV pictures of 8 bits a sample as cameras, decoders and encoders have them: borrowed views, and the buffer
// that owns one.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/frame/image.h"

namespace cupola {

// Where chroma is sampled every other texel, its sample lies in the middle of those it stands for, as in
// JPEG. With an odd number of texels the last sample stands for one that is there and one that is not.
enum class YuvLayout : std::uint8_t {
  kNv12,  // 4:2:0: a plane of Y, a plane of bytes U V U V ...
  kI420,  // 4:2:0: planes of Y, U and V; U and V have the same stride
  kYuyv,  // 4:2:2: one plane, bytes Y0 U Y1 V
  kUyvy,  // 4:2:2: one plane, bytes U Y0 V Y1
};

enum class YuvMatrix : std::uint8_t { kBt601, kBt709 };
enum class YuvRange : std::uint8_t {
  kLimited,  // Y 16 to 235, U and V 16 to 240
  kFull,     // all 0 to 255
};

// What the numbers mean.
struct YuvColour {
  YuvMatrix matrix = YuvMatrix::kBt601;
  YuvRange range = YuvRange::kLimited;
};

constexpr bool is_packed(YuvLayout layout) {
  return layout == YuvLayout::kYuyv || layout == YuvLayout::kUyvy;
}

constexpr Size chroma_size(YuvLayout layout, Size size) {
  return {(size.width + 1) / 2, is_packed(layout) ? size.height : (size.height + 1) / 2};
}

constexpr std::size_t plane_count(YuvLayout layout) {
  return layout == YuvLayout::kNv12 ? 2 : layout == YuvLayout::kI420 ? 3 : 1;
}

// Bytes of a row of plane `p`, and rows: as width and height.
constexpr Size plane_bytes(YuvLayout layout, Size size, std::size_t p) {
  const Size chroma = chroma_size(layout, size);
  if (is_packed(layout)) return {4 * chroma.width, size.height};
  if (p == 0) return size;
  return {layout == YuvLayout::kNv12 ? 2 * chroma.width : chroma.width, chroma.height};
}

// A picture somewhere in memory, borrowed: valid as long as whoever owns the memory says.
template <class Byte>
struct BasicYuvImage {
  YuvLayout layout = YuvLayout::kNv12;
  YuvColour colour;
  Size size;
  std::array<Plane<Byte>, 3> planes;
};
using YuvImage = BasicYuvImage<const std::uint8_t>;
using MutableYuvImage = BasicYuvImage<std::uint8_t>;

inline YuvImage as_const(const MutableYuvImage& image) {
  YuvImage view{image.layout, image.colour, image.size, {}};
  for (std::size_t p = 0; p < 3; ++p) view.planes[p] = {image.planes[p].data, image.planes[p].stride};
  return view;
}

// Where sample (x, y) of channel 0 to 2, Y, U and V, lies; U and V in their own size's coordinates.
template <class Byte>
Byte* sample_at(const BasicYuvImage<Byte>& image, int channel, int x, int y) {
  switch (image.layout) {
    case YuvLayout::kNv12:
      return channel == 0 ? image.planes[0].row(y) + x : image.planes[1].row(y) + 2 * x + channel - 1;
    case YuvLayout::kI420:
      return image.planes[static_cast<std::size_t>(channel)].row(y) + x;
    case YuvLayout::kYuyv:
      return image.planes[0].row(y) + (channel == 0 ? 2 * x : 4 * x + 2 * channel - 1);
    case YuvLayout::kUyvy:
      return image.planes[0].row(y) + (channel == 0 ? 2 * x + 1 : 4 * x + 2 * channel - 2);
  }
  return nullptr;
}

// Owns the memory of one picture, all zero at first. Rows begin on 64-byte boundaries.
class YuvBuffer {
 public:
  YuvBuffer() = default;
  YuvBuffer(YuvLayout layout, YuvColour colour, Size size);
  YuvBuffer(YuvBuffer&&) = default;
  YuvBuffer& operator=(YuvBuffer&&) = default;

  const MutableYuvImage& pixels() { return view_; }
  YuvImage pixels() const { return as_const(view_); }

 private:
  struct alignas(64) CacheLine {
    std::array<std::uint8_t, 64> bytes{};
  };
  std::vector<CacheLine> memory_;
  MutableYuvImage view_;
};

}  // namespace cupola
