// Pictures as cameras, decoders and encoders have them: of 8 bits a sample, or of 10.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/frame/yuv_colour.h"

namespace cupola {

// Where chroma is sampled every other texel, its sample lies in the middle of those it stands for, as in
// JPEG. With an odd number of texels the last sample stands for one that is there and one that is not.
enum class NativeLayout : std::uint8_t {
  kNv12,    // 4:2:0: a plane of Y, a plane of bytes U V U V ...
  kP010,    // the same in little-endian words, whose upper 10 bits are the sample
  kI420,    // 4:2:0: planes of Y, U and V; U and V have the same stride
  kI422,    // 4:2:2: the same planes
  kYuyv,    // 4:2:2: one plane, bytes Y0 U Y1 V
  kUyvy,    // 4:2:2: one plane, bytes U Y0 V Y1
  kRgb24,   // one plane, bytes R G B; no chroma apart
  kBgr24,   // bytes B G R
  kXrgb32,  // bytes B G R and one that means nothing: little-endian words 0x--RRGGBB
};

constexpr bool is_rgb(NativeLayout layout) {
  return layout >= NativeLayout::kRgb24;
}

// Luma and chroma in one plane.
constexpr bool is_packed(NativeLayout layout) {
  return layout == NativeLayout::kYuyv || layout == NativeLayout::kUyvy;
}

constexpr int sample_bytes(NativeLayout layout) {
  return layout == NativeLayout::kP010 ? 2 : 1;
}

// Bytes from a texel of luma, or of RGB, to the next.
constexpr int texel_step(NativeLayout layout) {
  if (is_rgb(layout)) return layout == NativeLayout::kXrgb32 ? 4 : 3;
  return is_packed(layout) ? 2 : sample_bytes(layout);
}

// U and V by turns in a plane of their own.
constexpr bool is_half_planar(NativeLayout layout) {
  return layout == NativeLayout::kNv12 || layout == NativeLayout::kP010;
}

// 4:2:2, not 4:2:0.
constexpr bool has_chroma_in_every_row(NativeLayout layout) {
  return is_packed(layout) || layout == NativeLayout::kI422;
}

constexpr Size chroma_size(NativeLayout layout, Size size) {
  if (is_rgb(layout)) return {};
  return {(size.width + 1) / 2, has_chroma_in_every_row(layout) ? size.height : (size.height + 1) / 2};
}

constexpr std::size_t plane_count(NativeLayout layout) {
  return is_packed(layout) || is_rgb(layout) ? 1 : is_half_planar(layout) ? 2 : 3;
}

// Bytes of a row of plane `p`, and rows: as width and height.
constexpr Size plane_bytes(NativeLayout layout, Size size, std::size_t p) {
  if (is_rgb(layout)) return {texel_step(layout) * size.width, size.height};
  const Size chroma = chroma_size(layout, size);
  if (is_packed(layout)) return {4 * chroma.width, size.height};
  if (p == 0) return {texel_step(layout) * size.width, size.height};
  return {is_half_planar(layout) ? 2 * sample_bytes(layout) * chroma.width : chroma.width, chroma.height};
}

// A picture somewhere in memory, borrowed: valid as long as whoever owns the memory says.
template <class Byte>
struct BasicNativeImage {
  NativeLayout layout = NativeLayout::kNv12;
  YuvColour colour;
  Size size;
  std::array<Plane<Byte>, 3> planes;
};
using NativeImage = BasicNativeImage<const std::uint8_t>;
using MutableNativeImage = BasicNativeImage<std::uint8_t>;

inline NativeImage as_const(const MutableNativeImage& image) {
  NativeImage view{image.layout, image.colour, image.size, {}};
  for (std::size_t p = 0; p < 3; ++p) view.planes[p] = {image.planes[p].data, image.planes[p].stride};
  return view;
}

// Of a larger picture the part of `size` texels that begins at (x, y), both even.
template <class Byte>
BasicNativeImage<Byte> part_of(const BasicNativeImage<Byte>& image, int x, int y, Size size) {
  BasicNativeImage<Byte> part = image;
  part.size = size;
  for (std::size_t p = 0; p < plane_count(image.layout); ++p) {
    const Size before = plane_bytes(image.layout, {x, y}, p);
    part.planes[p].data += before.height * image.planes[p].stride + before.width;
  }
  return part;
}

// The reverse: a picture of `size` texels of which no more than `part`, from (x, y) on, is in memory. Nothing
// else of it may be looked at.
template <class Byte>
BasicNativeImage<Byte> whole_of(const BasicNativeImage<Byte>& part, int x, int y, Size size) {
  BasicNativeImage<Byte> whole = part;
  whole.size = size;
  for (std::size_t p = 0; p < plane_count(part.layout); ++p) {
    const Size before = plane_bytes(part.layout, {x, y}, p);
    whole.planes[p].data -= before.height * part.planes[p].stride + before.width;
  }
  return whole;
}

// Where sample (x, y) of channel 0 to 2 lies: Y, U and V, or R, G and B; U and V in their own size's
// coordinates. Of two bytes the upper one, which is the sample in 8 bits.
template <class Byte>
Byte* sample_at(const BasicNativeImage<Byte>& image, int channel, int x, int y) {
  switch (image.layout) {
    case NativeLayout::kNv12:
      return channel == 0 ? image.planes[0].row(y) + x : image.planes[1].row(y) + 2 * x + channel - 1;
    case NativeLayout::kP010:
      return channel == 0 ? image.planes[0].row(y) + 2 * x + 1
                          : image.planes[1].row(y) + 4 * x + 2 * channel - 1;
    case NativeLayout::kI420:
    case NativeLayout::kI422:
      return image.planes[static_cast<std::size_t>(channel)].row(y) + x;
    case NativeLayout::kYuyv:
      return image.planes[0].row(y) + (channel == 0 ? 2 * x : 4 * x + 2 * channel - 1);
    case NativeLayout::kUyvy:
      return image.planes[0].row(y) + (channel == 0 ? 2 * x + 1 : 4 * x + 2 * channel - 2);
    case NativeLayout::kRgb24:
      return image.planes[0].row(y) + 3 * x + channel;
    case NativeLayout::kBgr24:
      return image.planes[0].row(y) + 3 * x + 2 - channel;
    case NativeLayout::kXrgb32:
      return image.planes[0].row(y) + 4 * x + 2 - channel;
  }
  return nullptr;
}

// Owns the memory of one picture, all zero at first. Rows begin on 64-byte boundaries.
class NativeBuffer {
 public:
  NativeBuffer() = default;
  NativeBuffer(NativeLayout layout, YuvColour colour, Size size);
  NativeBuffer(NativeBuffer&&) = default;
  NativeBuffer& operator=(NativeBuffer&&) = default;

  const MutableNativeImage& pixels() { return view_; }
  NativeImage pixels() const { return as_const(view_); }

 private:
  struct alignas(64) CacheLine {
    std::array<std::uint8_t, 64> bytes{};
  };
  std::vector<CacheLine> memory_;
  MutableNativeImage view_;
};

}  // namespace cupola
