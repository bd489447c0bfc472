// Origins, strides and steps of native planes.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/native_views.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "pipeline/warp/mirrored_texels.h"

namespace cupola {
namespace {

ViewTexels rgb_view(const NativeImage& face, const Reflection::Partner& partner) {
  ViewTexels texels = mirrored_texels(face.planes[0], face.size, texel_step(face.layout), partner);
  texels.channel = {0, 1, 2};
  if (face.layout != NativeLayout::kRgb24) texels.channel = {2, 1, 0};
  return texels;
}

ViewTexels luma_view(const NativeImage& face, const Reflection::Partner& partner) {
  ViewTexels texels = mirrored_texels(face.planes[0], face.size, texel_step(face.layout), partner);
  texels.channel[0] = face.layout == NativeLayout::kUyvy ? 1 : 0;
  return texels;
}

ViewTexels chroma_view(const NativeImage& face, const Reflection::Partner& partner) {
  const Plane<const std::uint8_t>& plane = face.planes[is_packed(face.layout) ? 0 : 1];
  ViewTexels texels =
      mirrored_texels(plane, chroma_size(face.layout, face.size), chroma_step(face.layout), partner);
  switch (face.layout) {
    case NativeLayout::kNv12:
      texels.channel = {0, 1, 0};
      break;
    case NativeLayout::kP010:
      texels.channel = {0, 2, 0};
      break;
    case NativeLayout::kI420:
    case NativeLayout::kI422:
      assert(face.planes[1].stride == face.planes[2].stride);
      texels.channel = {0, face.planes[2].data - face.planes[1].data, 0};
      break;
    case NativeLayout::kYuyv:
      texels.channel = {1, 3, 0};
      break;
    case NativeLayout::kUyvy:
      texels.channel = {0, 2, 0};
      break;
    case NativeLayout::kRgb24:
    case NativeLayout::kBgr24:
    case NativeLayout::kXrgb32:
      assert(false);  // RGB has no chroma
  }
  return texels;
}

}  // namespace

NativeViews::NativeViews(NativeLayout layout, std::span<const View> views)
    : layout_(layout), padded_(views.size()), faces_(views.size()) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Size size = sizes_.emplace_back(views[i].size);
    const Size least = is_rgb(layout) ? size : chroma_size(layout, size);
    if (least.width >= kWindowSide && least.height >= kWindowSide) continue;
    padded_[i] = NativeBuffer(
        layout, {}, {std::max(size.width, 2 * kWindowSide), std::max(size.height, 2 * kWindowSide)});
  }
}

void NativeViews::set(std::span<const NativeImage> faces) {
  for (std::size_t i = 0; i < faces.size(); ++i) {
    assert(faces[i].layout == layout_);
    faces_[i] = faces[i];
    if (!copies(i)) continue;
    const MutableNativeImage& room = padded_[i].pixels();
    for (std::size_t p = 0; p < plane_count(layout_); ++p) {
      const Size bytes = plane_bytes(layout_, faces[i].size, p);
      for (int y = 0; y < bytes.height; ++y) {
        std::memcpy(room.planes[p].row(y), faces[i].planes[p].row(y), static_cast<std::size_t>(bytes.width));
      }
      faces_[i].planes[p] = {room.planes[p].data, room.planes[p].stride};
    }
  }
}

ReflectedViews NativeViews::rgb(const WarpTable& table) const {
  return reflected_views<NativeImage>(table, faces_, rgb_view);
}

ReflectedViews NativeViews::luma(const WarpTable& table) const {
  return reflected_views<NativeImage>(table, faces_, luma_view);
}

ReflectedViews NativeViews::chroma(const WarpTable& table) const {
  return reflected_views<NativeImage>(table, faces_, chroma_view);
}

}  // namespace cupola
