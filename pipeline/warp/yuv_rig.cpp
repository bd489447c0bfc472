// Chroma texels are wider luma texels; everything else follows from that.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/yuv_rig.h"

#include <cmath>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

// Texel i of `chroma` is texels 2 i and 2 i + 1 of `whole`: where the last of those is not there, the view
// reaches beyond its picture by half a texel.
double stretch(int whole, int chroma) {
  return whole > chroma ? whole / (2.0 * chroma) : 1.0;
}

View chroma_view(const View& view, NativeLayout layout) {
  View chroma = view;
  chroma.size = chroma_size(layout, view.size);
  const Vec2 share{stretch(view.size.width, chroma.size.width),
                   has_chroma_in_every_row(layout) ? 1.0 : stretch(view.size.height, chroma.size.height)};
  chroma.focal = {view.focal.x * share.x, view.focal.y * share.y};
  chroma.principal = {view.principal.x * share.x, view.principal.y * share.y};
  return chroma;
}

// Variance of exp(-alpha s^2), s < radius, along one axis, pixels^2.
double variance(const FilterSettings& filter) {
  const double cut = filter.alpha * filter.radius * filter.radius;
  return (1.0 - cut / std::expm1(cut)) / (2.0 * filter.alpha);
}

}  // namespace

Rig chroma_rig(const Rig& rig, NativeLayout layout) {
  Rig chroma = rig;
  for (View& view : chroma.views) view = chroma_view(view, layout);
  // Variances add: a triangle two texels wide at half its height has 1/6 of a texel^2; what `rig`
  // reconstructs by is in texels half as wide.
  chroma.filter.rec = rig.filter.rec / 4.0 + 1.0 / (6.0 * variance(rig.filter));
  if (has_chroma_in_every_row(layout)) {
    for (View& view : chroma.views) view.rec_v = rig.filter.rec / chroma.filter.rec;
  }
  return chroma;
}

Rig half_frame_chroma_rig(const Rig& rig, NativeLayout layout) {
  Rig chroma = rig;
  for (View& view : chroma.views) view = chroma_view(view, layout);
  FrameGeometry& frame = chroma.frame;
  const bool centred = frame.model == FrameModel::kFisheye || frame.model == FrameModel::kChromeBall;
  const auto halve = [&](Size& size) {
    if (!centred && (size.width % 2 != 0 || size.height % 2 != 0)) {
      throw InputError(
          "a map of the world and the faces of a cube need even sizes to have half as much chroma");
    }
    size = {(size.width + 1) / 2, (size.height + 1) / 2};
  };
  halve(frame.size);
  for (View& face : frame.faces) halve(face.size);
  frame.center = {frame.center.x / 2.0, frame.center.y / 2.0};
  frame.radius /= 2.0;
  return chroma;
}

}  // namespace cupola
