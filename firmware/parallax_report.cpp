// One line for the distance, one for each other distance looked at.
// SPDX-License-Identifier: MIT
#include "firmware/parallax_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pipeline/optics/parallax.h"
#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

// Where nothing tells a view's size, any will do for the angles. Returns whether all are known.
bool take_sizes(Rig& rig, std::span<const RigCamera> cameras) {
  bool known = true;
  for (View& view : rig.views) {
    const auto camera = std::find_if(cameras.begin(), cameras.end(),
                                     [&](const RigCamera& of) { return of.view == view.name; });
    if (view.size == Size{} && camera != cameras.end())
      view.size = {camera->setup.width, camera->setup.height};
    if (view.size.width > 0 && view.size.height > 0) continue;
    view.size = {1000, 1000};
    known = false;
  }
  return known;
}

void print_at(const Rig& rig, bool sizes_known, double distance_m) {
  const SeamParallax parallax = parallax_at_seams(rig, distance_m);
  if (parallax.first < 0) return;
  const std::string where = std::isinf(distance_m) ? "at infinity" : fmt::format("at {:.4g} m", distance_m);
  const std::string texels = sizes_known ? fmt::format(" ({:.1f} texels)", parallax.texels) : "";
  fmt::print("seams: {} views are up to {:.2f} degrees{} apart, {} and {}\n", where,
             parallax.radians * 180.0 / portable::kPi, texels,
             rig.views[static_cast<std::size_t>(parallax.first)].name,
             rig.views[static_cast<std::size_t>(parallax.second)].name);
}

}  // namespace

void print_parallax(const Rig& rig, std::span<const RigCamera> cameras) {
  double farthest = 0.0;
  for (const View& view : rig.views) farthest = std::max(farthest, glm::length(view.position_m));
  if (farthest == 0.0) return;
  Rig sized = rig;
  const bool known = take_sizes(sized, cameras);
  const double closes = rig.seams.distance_m;
  if (std::isinf(closes)) {
    fmt::print("seams: close at infinity; views are up to {:.4g} m off the rig's centre\n", farthest);
    for (const double positions : {100.0, 20.0}) print_at(sized, known, positions * farthest);
    return;
  }
  fmt::print("seams: close at {:.4g} m; views are up to {:.4g} m off the rig's centre\n", closes, farthest);
  print_at(sized, known, 2.0 * closes);
  print_at(sized, known, HUGE_VAL);
}

}  // namespace cupola
