// Faces in memory as a reflection of the frame sees them.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "pipeline/frame/image.h"
#include "pipeline/warp/band_run.h"

namespace cupola {

// One plane's texels of `step` bytes, `size` of them. All channels begin where the first does.
inline ViewTexels mirrored_texels(const Plane<const std::uint8_t>& plane, Size size, int step,
                                  const Reflection::Partner& partner) {
  ViewTexels texels;
  const int x = partner.flip_u ? size.width - kWindowSide : 0;
  const int y = partner.flip_v ? size.height - 1 : 0;
  texels.origin = plane.row(y) + x * step;
  texels.stride = partner.flip_v ? -plane.stride : plane.stride;
  texels.step = step;
  texels.across = partner.flip_u ? -step : step;
  texels.flip = partner.flip_u ? 0x07070707 : 0;
  return texels;
}

// look(face, partner) of every view in every reflection of the table.
template <class Face, class Look>
ReflectedViews reflected_views(const WarpTable& table, std::span<const Face> faces, Look&& look) {
  ReflectedViews views;
  for (std::size_t i = 0; i < table.reflections.size(); ++i) {
    for (std::size_t view = 0; view < faces.size(); ++view) {
      const Reflection::Partner& partner = table.reflections[i].views[view];
      views[i][view] = look(faces[partner.view], partner);
    }
  }
  return views;
}

}  // namespace cupola
