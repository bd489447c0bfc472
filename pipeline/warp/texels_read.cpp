// A union over tiles and mirror images.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/texels_read.h"

#include <algorithm>

namespace cupola {
namespace {

TexelBox mirrored(const TexelBox& box, Size view, const Reflection::Partner& partner) {
  TexelBox image = box;
  if (partner.flip_u) {
    image.x0 = view.width - box.x1;
    image.x1 = view.width - box.x0;
  }
  if (partner.flip_v) {
    image.y0 = view.height - box.y1;
    image.y1 = view.height - box.y0;
  }
  return image;
}

}  // namespace

std::vector<TexelBox> texels_read(const WarpTable& table) {
  std::vector<TexelBox> stored(table.views.size());
  for (const Reach& reach : table.reaches) {
    const Size view = table.views[reach.view];
    TexelBox& box = stored[reach.view];
    box = box_around(box, {reach.x0, reach.y0, reach.x1, std::min(reach.y1 + 1, view.height)});
  }
  std::vector<TexelBox> boxes(table.views.size());
  for (const Reflection& reflection : table.reflections) {
    for (std::size_t view = 0; view < stored.size(); ++view) {
      if (stored[view].empty()) continue;
      const Reflection::Partner& partner = reflection.views[view];
      TexelBox& box = boxes[partner.view];
      box = box_around(box, mirrored(stored[view], table.views[partner.view], partner));
    }
  }
  return boxes;
}

TexelBox box_around(const TexelBox& a, const TexelBox& b) {
  if (a.empty() || b.empty()) return a.empty() ? b : a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

TexelBox even_box(const TexelBox& box, Size view) {
  return {box.x0 / 2 * 2, box.y0 / 2 * 2, std::min((box.x1 + 1) / 2 * 2, view.width),
          std::min((box.y1 + 1) / 2 * 2, view.height)};
}

}  // namespace cupola
