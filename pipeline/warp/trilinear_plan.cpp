// Mip-maps: two levels about the pixel's larger side, four texels in each, clamped at the view's edge.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "pipeline/warp/pyramid_plan.h"

namespace cupola {
namespace {

// The four texels about (u, v), shares of the view's width and height, of one image.
void add_bilinear(Size size, const Vec2& at, int image, double share, std::vector<Tap>& taps) {
  const double u = at.x * size.width - 0.5;
  const double v = at.y * size.height - 0.5;
  const double x = std::floor(u);
  const double y = std::floor(v);
  for (int corner = 0; corner < 4; ++corner) {
    const double wide = corner % 2 == 0 ? 1.0 - (u - x) : u - x;
    const double high = corner / 2 == 0 ? 1.0 - (v - y) : v - y;
    if (share * wide * high <= 0.0) continue;
    taps.push_back({static_cast<int>(std::clamp(x + corner % 2, 0.0, size.width - 1.0)),
                    static_cast<int>(std::clamp(y + corner / 2, 0.0, size.height - 1.0)), image,
                    share * wide * high});
  }
}

}  // namespace

PyramidPlan plan_trilinear(const Rig& rig, WorkerPool& pool) {
  PyramidShape shape = shape_pyramid(rig, Reduction::kBox);
  const int views = static_cast<int>(rig.views.size());
  TapRuns taps = collect_tap_runs(rig.frame.size, pool, [&](int x, int y, std::vector<Tap>& pixel) {
    DirectionAndSlope looking;
    ViewSample at;
    if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking)) return;
    const int home = owner(rig.views, looking.direction);
    if (home < 0 || !project(rig.views[static_cast<std::size_t>(home)], looking.direction, at)) return;
    const Size face = rig.views[static_cast<std::size_t>(home)].size;
    const double along_x = std::hypot(glm::dot(at.du, looking.d_da), glm::dot(at.dv, looking.d_da));
    const double along_y = std::hypot(glm::dot(at.du, looking.d_db), glm::dot(at.dv, looking.d_db));
    const double level = std::clamp(std::log2(std::max({along_x, along_y, 1.0})), 0.0,
                                    static_cast<double>(shape.levels.size()) - 1.0);
    const Vec2 share{at.uv.x / face.width, at.uv.y / face.height};
    for (int step = 0; step < 2; ++step) {
      const int of = static_cast<int>(level) + step;
      const double weight = step == 0 ? 1.0 - (level - std::floor(level)) : level - std::floor(level);
      if (weight <= 0.0) continue;
      add_bilinear(shape.levels[static_cast<std::size_t>(of)].sizes[static_cast<std::size_t>(home)], share,
                   of * views + home, weight, pixel);
    }
  });
  return {std::move(shape), std::move(taps)};
}

}  // namespace cupola
