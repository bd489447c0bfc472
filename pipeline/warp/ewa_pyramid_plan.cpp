// Footprints on pyramid levels: the level's own blur is taken out of the ellipse, so that both together are
// the filter that was asked for.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "pipeline/warp/footprint.h"
#include "pipeline/warp/pyramid_plan.h"

namespace cupola {
namespace {

// What the smaller axis of an ellipse must have left on a level, as a variance in texels^2, once the level's
// own is taken out. Less gives fewer texels a pixel and more aliasing between the level's texels.
constexpr double kLeastVariance = 0.08;
// The share of a step from level to level over which one fades into the next.
constexpr double kFade = 0.0625;
// Weights below exp(-kCut) of the largest are left out on levels; the rest is widened to the same variance.
constexpr double kCut = 2.8;

// A Gaussian exp(-q) has the variance 1/2 along any axis of the plane whose square distance is q; cut at
// q = `cut` it keeps this share of it.
double kept_by_cut(double cut) {
  return 1.0 - cut / std::expm1(cut);
}

class LevelChooser {
 public:
  explicit LevelChooser(const Rig& rig)
      : rig_(rig),
        shape_(shape_pyramid(rig, Reduction::kGaussian)),
        variance_(kept_by_cut(rig.filter.alpha * rig.filter.radius * rig.filter.radius) /
                  (2.0 * rig.filter.alpha)) {
    for (std::size_t level = 0; level < shape_.levels.size(); ++level) rigs_.push_back(level_rig(level));
    for (const Rig& each : rigs_) gatherers_.emplace_back(each);
  }

  const PyramidShape& shape() const { return shape_; }

  void gather(int x, int y, std::vector<Tap>& taps) const {
    double fade = 1.0;
    const std::size_t level = choose(x, y, fade);
    std::vector<Tap> finer;
    if (fade < 1.0) add(level - 1, x, y, 1.0 - fade, finer);
    add(level, x, y, finer.empty() ? 1.0 : fade, taps);
    if (taps.empty() && level > 0) add(0, x, y, finer.empty() ? 1.0 : fade, taps);
    taps.insert(taps.end(), finer.begin(), finer.end());
  }

 private:
  // The same views with the level's sizes, and the filter less the level's variance.
  Rig level_rig(std::size_t level) const {
    Rig rig = rig_;
    if (level == 0) return rig;
    const double scale = shape_.levels[level].scale;
    for (std::size_t view = 0; view < rig.views.size(); ++view) {
      rig.views[view].size = shape_.levels[level].sizes[view];
    }
    rig.filter.alpha = kept_by_cut(kCut) / (2.0 * variance_);
    rig.filter.rec = rig_.filter.rec / (scale * scale) - kLevelVariance / variance_;
    rig.filter.radius = std::sqrt(kCut / rig.filter.alpha);
    return rig;
  }

  // The smallest level on which the pixel's ellipse keeps kLeastVariance, and its share; the rest belongs to
  // the level before.
  std::size_t choose(int x, int y, double& fade) const {
    DirectionAndSlope looking;
    ViewSample at;
    if (!ray(rig_.frame, {x + 0.5, y + 0.5}, looking)) return 0;
    const int home = owner(rig_.views, looking.direction);
    if (home < 0 || !project(rig_.views[static_cast<std::size_t>(home)], looking.direction, at)) return 0;
    const Vec2 along_x{glm::dot(at.du, looking.d_da), glm::dot(at.dv, looking.d_da)};
    const Vec2 along_y{glm::dot(at.du, looking.d_db), glm::dot(at.dv, looking.d_db)};
    const Size face = rig_.views[static_cast<std::size_t>(home)].size;
    std::size_t best = 0;
    for (std::size_t level = 1; level < shape_.levels.size(); ++level) {
      const Size size = shape_.levels[level].sizes[static_cast<std::size_t>(home)];
      const Vec2 shrink{static_cast<double>(size.width) / face.width,
                        static_cast<double>(size.height) / face.height};
      const Vec2 a = along_x * shrink;
      const Vec2 b = along_y * shrink;
      const double uu = a.x * a.x + b.x * b.x;
      const double vv = a.y * a.y + b.y * b.y;
      const double uv = a.x * a.y + b.x * b.y;
      const double smaller = (uu + vv) / 2 - std::hypot((uu - vv) / 2, uv);
      const double least = (smaller + rigs_[level].filter.rec) * variance_;
      if (least < kLeastVariance) break;
      best = level;
      const double above = std::log2((least + kLevelVariance) / (kLeastVariance + kLevelVariance));
      fade = std::min(1.0, above * kLevelsAnOctave / (2.0 * kFade));
    }
    return best;
  }

  void add(std::size_t level, int x, int y, double share, std::vector<Tap>& taps) const {
    if (gatherers_[level].gather(x, y, taps) != Footprint::kCovered) {
      taps.clear();
      return;
    }
    for (Tap& tap : taps) {
      tap.view += static_cast<int>(level * shape_.views());
      tap.weight *= share;
    }
  }

  const Rig& rig_;
  PyramidShape shape_;
  double variance_;  // of the filter, pixels^2
  std::vector<Rig> rigs_;
  std::vector<FootprintGatherer> gatherers_;
};

}  // namespace

PyramidPlan plan_ewa_pyramid(const Rig& rig, WorkerPool& pool) {
  Rig gaussian = rig;
  if (rig.filter.kernel != Kernel::kGaussian) gaussian.filter = default_gaussian();
  const LevelChooser chooser(gaussian);
  return {chooser.shape(), collect_tap_runs(rig.frame.size, pool, [&](int x, int y, std::vector<Tap>& taps) {
            chooser.gather(x, y, taps);
          })};
}

}  // namespace cupola
