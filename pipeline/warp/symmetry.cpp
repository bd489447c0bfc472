// A rig mirrors where its frame does and every view has a partner.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/symmetry.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace cupola {
namespace {

constexpr double kSameDirection = 1e-12;

bool same(const Vec3& a, const Vec3& b) {
  return std::abs(a.x - b.x) < kSameDirection && std::abs(a.y - b.y) < kSameDirection &&
         std::abs(a.z - b.z) < kSameDirection;
}

bool frame_mirrors(const FrameGeometry& frame, bool across, bool down) {
  if (frame.model == FrameModel::kCube) return false;
  if (down && frame.crop != Crop::kNone) return false;
  if (frame.model != FrameModel::kFisheye && frame.model != FrameModel::kChromeBall) return true;
  return (!across || 2.0 * frame.center.x == frame.size.width) &&
         (!down || 2.0 * frame.center.y == frame.size.height);
}

// Windows of a view smaller than they are would not mirror onto themselves.
bool can_mirror(const View& view) {
  return view.distortion == Distortion::kNone && view.principal.x == 0.5 && view.principal.y == 0.5 &&
         view.size.width >= kWindowSide && view.size.height >= kWindowSide;
}

// How `to` shows what `from` shows in a mirror that turns directions by `sign`; a mirror image of a
// right-handed view is another with one of its axes turned round.
std::optional<Reflection::Partner> partner(const View& from, const View& to, const Vec3& sign) {
  if (!can_mirror(from) || !can_mirror(to) || !(from.size == to.size) || from.focal.x != to.focal.x ||
      from.focal.y != to.focal.y || !same(from.forward * sign, to.forward) ||
      !same(from.shift * sign, to.shift)) {
    return std::nullopt;
  }
  const Vec3 right = from.right * sign;
  const Vec3 up = from.up * sign;
  if (same(right, -to.right) && same(up, to.up)) return Reflection::Partner{0, true, false};
  if (same(right, to.right) && same(up, -to.up)) return Reflection::Partner{0, false, true};
  return std::nullopt;
}

std::optional<Reflection> reflect(const Rig& rig, bool across, bool down) {
  if (!frame_mirrors(rig.frame, across, down)) return std::nullopt;
  Reflection reflection;
  reflection.across = across;
  reflection.down = down;
  const Vec3 sign{across ? -1.0 : 1.0, down ? -1.0 : 1.0, 1.0};
  for (std::size_t i = 0; i < rig.views.size(); ++i) {
    bool found = false;
    for (std::size_t j = 0; j < rig.views.size() && !found; ++j) {
      const auto pair = partner(rig.views[i], rig.views[j], sign);
      if (!pair) continue;
      reflection.views[i] = *pair;
      reflection.views[i].view = static_cast<std::uint8_t>(j);
      found = true;
    }
    if (!found) return std::nullopt;
  }
  return reflection;
}

// First `a`, then `b`.
Reflection both(const Reflection& a, const Reflection& b) {
  Reflection reflection;
  reflection.across = true;
  reflection.down = true;
  for (std::size_t i = 0; i < kMostViews; ++i) {
    const Reflection::Partner& first = a.views[i];
    const Reflection::Partner& second = b.views[first.view];
    reflection.views[i] = {second.view, first.flip_u != second.flip_u, first.flip_v != second.flip_v};
  }
  return reflection;
}

}  // namespace

std::vector<Reflection> find_reflections(const Rig& rig) {
  Reflection itself;
  for (std::size_t i = 0; i < kMostViews; ++i) itself.views[i].view = static_cast<std::uint8_t>(i);
  const auto across = reflect(rig, true, false);
  const auto down = reflect(rig, false, true);
  std::vector<Reflection> reflections;
  if (across && down) reflections.push_back(both(*across, *down));
  if (down) reflections.push_back(*down);
  if (across) reflections.push_back(*across);
  reflections.push_back(itself);
  return reflections;
}

}  // namespace cupola
