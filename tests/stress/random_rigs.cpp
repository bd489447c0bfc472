// What may be drawn, and how often.
// SPDX-License-Identifier: MIT
#include "tests/stress/random_rigs.h"

#include <algorithm>
#include <cmath>

#include "pipeline/optics/calibration.h"
#include "pipeline/portable/portable_math.h"

namespace cupola::test {
namespace {

using portable::kPi;
using portable::radians;

constexpr const char* kNames[] = {"front", "left", "right", "top", "bottom", "back"};
constexpr int kRowsApart = 61;  // texels
constexpr int kLongestSide = 65535;

void turn(View& view, const Mat3& pose) {
  view.forward = pose * view.forward;
  view.right = pose * view.right;
  view.up = pose * view.up;
}

double focal_of(double fov_deg) {
  return 0.5 / std::tan(radians(fov_deg / 2));
}

// OpenCV's models, drawn until one is one-to-one over the picture.
void bend(Dice& dice, View& view) {
  const View straight = view;
  for (int tries = 0; tries < 20; ++tries) {
    view = straight;
    view.principal = {dice.real(0.4, 0.6), dice.real(0.4, 0.6)};
    if (dice.one_in(2)) {
      view.distortion = Distortion::kFisheye;
      view.focal = {dice.real(0.2, 0.7), dice.real(0.2, 0.7)};
      for (int i = 0; i < 4; ++i) view.coefficients[i] = dice.real(-0.03, 0.03) / (1 << i);
    } else {
      view.distortion = Distortion::kRadialTangential;
      view.focal = {dice.real(0.35, 2.0), dice.real(0.35, 2.0)};
      view.coefficients = {dice.real(-0.2, 0.2),
                           dice.real(-0.05, 0.05),
                           dice.real(-0.003, 0.003),
                           dice.real(-0.003, 0.003),
                           dice.real(-0.01, 0.01),
                           0.0,
                           0.0,
                           0.0};
      if (dice.one_in(3)) view.coefficients[5] = dice.real(-0.1, 0.3);
    }
    if (limit_distortion(view).empty()) return;
  }
  view = straight;
}

double fov_deg(Dice& dice) {
  switch (dice.whole(0, 3)) {
    case 0:
      return dice.log_uniform(1.0, 60.0);
    case 1:
      return dice.real(150.0, 179.0);
    default:
      return dice.real(60.0, 150.0);
  }
}

// One in four is signed.
FilterSettings random_filter(Dice& dice) {
  FilterSettings filter;
  const TableForm table = dice.one_in(2) ? TableForm::kFast : TableForm::kPrecise;
  if (dice.one_in(4)) {
    const int kernel = dice.whole(0, 3);
    filter = kernel == 0   ? robidoux_filter()
             : kernel == 1 ? jinc_filter()
                           : optimal_filter(dice.log_uniform(1e-5, 1e-1));
    filter.table = table;
    return filter;
  }
  if (dice.one_in(3)) filter = dice.one_in(2) ? paper_preset() : FilterSettings{};
  if (dice.one_in(2)) {
    filter.radius = dice.one_in(5) ? dice.log_uniform(0.25, 8.0) : dice.real(0.5, 2.5);
    filter.alpha = dice.log_uniform(0.01, std::min(50.0, 64.0 / (filter.radius * filter.radius)));
    filter.rec = dice.one_in(4) ? dice.real(0.0, 16.0) : dice.real(0.0, 1.0);
  }
  filter.table = table;
  return filter;
}

void random_frame(Dice& dice, Rig& rig) {
  FrameGeometry& frame = rig.frame;
  frame.size = {dice.whole(1, 4000), dice.whole(1, 4000)};
  frame.center = {frame.size.width / 2.0, frame.size.height / 2.0};
  frame.radius = std::min(frame.size.width, frame.size.height) / 2.0;
  if (!dice.one_in(4)) return;
  frame.model = static_cast<FrameModel>(dice.whole(1, 5));
  frame.fov = radians(dice.one_in(2) ? 360.0 : dice.log_uniform(1.0, 360.0));
  if (frame.model != FrameModel::kCube) return;
  frame.columns = dice.whole(1, 3);
  const int rows = dice.whole(1, 2);
  const Size cell{dice.whole(1, 1000), dice.whole(1, 1000)};
  frame.size = {cell.width * frame.columns, cell.height * rows};
  for (int i = 0; i < frame.columns * rows; ++i) {
    View face;
    named_pose(kNames[dice.whole(0, 5)], face);
    face.size = cell;
    frame.faces.push_back(face);
  }
}

}  // namespace

double Dice::log_uniform(double least, double most) {
  return std::exp(real(std::log(least), std::log(most)));
}

Vec3 Dice::direction() {
  for (;;) {
    const Vec3 d{real(-1, 1), real(-1, 1), real(-1, 1)};
    const double length = glm::length(d);
    if (length > 0.1 && length < 1.0) return d / length;
  }
}

Mat3 Dice::pose() {
  const Vec3 forward = direction();
  const Vec3 right = glm::normalize(glm::cross(forward, direction()));
  return {right, glm::cross(forward, right), forward};
}

Lens random_lens(Dice& dice) {
  const auto half = [&](double most) { return radians(dice.real(20.0, most) / 2); };
  switch (dice.whole(0, 5)) {
    case 0:
      return omnimax_c430();
    case 1:
      return equidistant(dice.real(20.0, 300.0));
    case 2:
      return {LensModel::kEquisolid, half(340.0), {}, {}};
    case 3:
      return {LensModel::kStereographic, half(340.0), {}, {}};
    case 4:
      return {LensModel::kOpencvFisheye, half(220.0), {dice.real(-0.02, 0.05), dice.real(-0.002, 0.005)}, {}};
    default:
      for (;;) {
        const Lens lens{LensModel::kPolynomial,
                        0.0,
                        {0.0, dice.log_uniform(0.05, 2.5), dice.real(-0.5, 0.5), dice.real(-0.3, 0.3), 0.0,
                         dice.real(-0.1, 0.3)},
                        {}};
        if (fault(lens).empty()) return lens;
      }
  }
}

std::vector<View> random_views(Dice& dice) {
  std::vector<View> views;
  const int kind = dice.whole(0, 4);
  const int count = kind == 0 ? 6 : dice.whole(1, 6);
  const Mat3 whole = dice.pose();
  const Size size{dice.whole(1, 2000), dice.whole(1, 2000)};
  for (int i = 0; i < count; ++i) {
    View view;
    named_pose(kNames[i], view);
    view.size = size;
    if (kind == 0 || kind == 1) {  // the cube or some of its faces, half of them turned as a whole
      if (size.width % 2 == 0) turn(view, whole);
    } else {  // each by itself
      turn(view, dice.pose());
      const int most = kind == 4 ? 60 : 2000;  // bent ones take much longer
      view.size = {dice.whole(1, most), dice.whole(1, most)};
      view.focal = {focal_of(fov_deg(dice)), focal_of(fov_deg(dice))};
      if (kind == 4 && !dice.one_in(4)) bend(dice, view);
    }
    views.push_back(view);
  }
  if (dice.one_in(3)) {
    for (View& view : views) view.shift = dice.pose() * Vec3{dice.log_uniform(1e-6, 0.5), 0.0, 0.0};
  }
  return views;
}

Rig random_rig(Dice& dice) {
  Rig rig;
  rig.frame.lens = random_lens(dice);
  rig.views = random_views(dice);
  rig.filter = random_filter(dice);
  random_frame(dice, rig);
  if (rig.frame.model == FrameModel::kFisheye || rig.frame.model == FrameModel::kChromeBall) {
    // From 16 texels a pixel to 64 pixels a texel, about; wide filters get narrower footprints.
    const View& view = rig.views.front();
    const double texels_a_radian = view.size.width * view.focal.x;
    const double most = 16.0 / std::max(1.0, rig.filter.radius);
    rig.frame.radius =
        std::clamp(texels_a_radian / dice.log_uniform(1.0 / 64.0, most), 0.5, double{kLongestSide});
    const int side = static_cast<int>(std::clamp(2.0 * rig.frame.radius, 1.0, double{kLongestSide}));
    rig.frame.size = {side, side};
    rig.frame.center = {side / 2.0, side / 2.0};
  }
  return rig;
}

bool aim(Rig& rig, const Vec3& d, int x, int y) {
  FrameGeometry& frame = rig.frame;
  double r = 0.0;
  const double across = std::hypot(d.x, d.y);
  if (frame.model == FrameModel::kFisheye) {
    const double phi = std::atan2(across, -d.z);
    if (phi > sample(frame.lens, 1.0).phi) return false;
    r = radius_at(frame.lens, phi);
  } else if (frame.model == FrameModel::kChromeBall) {
    r = std::sqrt(std::max(0.0, (1.0 - d.z) / 2.0));  // the normal's height is sqrt((1 + d.z) / 2)
  } else {
    return false;
  }
  const double scale = across > 0.0 ? r * frame.radius / across : 0.0;
  frame.center = {x + 0.5 - d.x * scale, y + 0.5 + d.y * scale};
  return true;
}

Pixel random_pixel(Dice& dice, Rig& rig) {
  const Pixel pixel{dice.whole(0, rig.frame.size.width - 1), dice.whole(0, rig.frame.size.height - 1)};
  if (rig.frame.model != FrameModel::kFisheye && rig.frame.model != FrameModel::kChromeBall) return pixel;
  const View& view =
      rig.views[static_cast<std::size_t>(dice.whole(0, static_cast<int>(rig.views.size()) - 1))];
  const double width = view.size.width;
  const double height = view.size.height;
  const auto on_edge = [&](double side) { return dice.one_in(2) ? 0.0 : side; };
  switch (dice.whole(0, 9)) {
    case 0:
      rig.frame.center = {pixel.x + 0.5, pixel.y + 0.5};  // the axis
      break;
    case 1: {  // the limb, to the last bit inside or outside of it
      const double angle = dice.one_in(3) ? dice.whole(0, 3) * (kPi / 2) : dice.real(0.0, 2 * kPi);
      const double r = dice.one_in(3) ? 1.0 : 1.0 - dice.log_uniform(1e-16, 1e-2);
      rig.frame.center = {pixel.x + 0.5 - r * rig.frame.radius * std::cos(angle),
                          pixel.y + 0.5 - r * rig.frame.radius * std::sin(angle)};
      break;
    }
    case 2:
      aim(rig, direction_at(view, {on_edge(width), on_edge(height)}), pixel.x, pixel.y);
      break;
    case 3:
      aim(rig, direction_at(view, {dice.real(0.0, width), on_edge(height)}), pixel.x, pixel.y);
      break;
    case 4:
      aim(rig, direction_at(view, {on_edge(width), dice.real(0.0, height)}), pixel.x, pixel.y);
      break;
    case 5:  // near the axis
      rig.frame.center = {pixel.x + 0.5 + dice.log_uniform(1e-12, 1.0) * rig.frame.radius, pixel.y + 0.5};
      break;
    case 6:  // anywhere
      rig.frame.center = {pixel.x + 0.5 + dice.real(-0.75, 0.75) * rig.frame.radius,
                          pixel.y + 0.5 + dice.real(-0.75, 0.75) * rig.frame.radius};
      break;
    default:
      aim(rig, direction_at(view, {dice.real(0.0, width), dice.real(0.0, height)}), pixel.x, pixel.y);
  }
  return pixel;
}

NoiseFaces::NoiseFaces(std::uint64_t seed) : noise_(std::size_t{kLongestSide} * (kRowsApart + 1) + 4096) {
  std::mt19937_64 engine(seed);
  for (std::uint8_t& byte : noise_) byte = static_cast<std::uint8_t>(engine() >> 56);
}

std::vector<Image> NoiseFaces::faces(const Rig& rig) const {
  std::vector<Image> faces;
  for (std::size_t i = 0; i < rig.views.size(); ++i) {
    Image face;
    face.size = rig.views[i].size;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      face.planes[channel] = {reinterpret_cast<const std::byte*>(noise_.data()) + i * 600 + channel * 200,
                              kRowsApart};
    }
    faces.push_back(face);
  }
  return faces;
}

}  // namespace cupola::test
