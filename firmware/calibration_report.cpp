// One line a camera, one a seam, one a shot that was left out.
// SPDX-License-Identifier: MIT
#include "firmware/calibration_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "pipeline/calibrate/pose.h"
#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

double degrees_off(const CameraCalibration& camera, const View& before) {
  return angle_between(camera_axes(camera.view), camera_axes(before)) * 180.0 / portable::kPi;
}

const std::string& name_of_shot(std::span<const std::string> shots, int shot) {
  return shots[static_cast<std::size_t>(shot)];
}

const char* model_name(const View& view) {
  return view.distortion == Distortion::kFisheye ? "fisheye" : "radial";
}

// The widest angle between opposite edges, degrees.
double field(const View& view) {
  const Vec3 left = direction_at(view, {0.0, 0.5 * view.size.height});
  const Vec3 right = direction_at(view, {static_cast<double>(view.size.width), 0.5 * view.size.height});
  const double a = std::atan2(glm::length(glm::cross(left, view.forward)), glm::dot(left, view.forward));
  const double b = std::atan2(glm::length(glm::cross(right, view.forward)), glm::dot(right, view.forward));
  return (a + b) * 180.0 / portable::kPi;
}

}  // namespace

std::string calibration_table(const RigCalibration& calibration, const Rig& rig,
                              std::span<const std::string> shots) {
  std::string text;
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const CameraCalibration& camera = calibration.cameras[c];
    if (!camera.has_lens) {
      text += fmt::format("camera {}: as in the rig file\n", camera.view.name);
      continue;
    }
    text += fmt::format(
        "camera {}: {} shots, off by {:.2f} texels, {:.2f} at most{}", camera.view.name, camera.shots,
        camera.rms, camera.worst,
        camera.worst_shot < 0 ? "" : fmt::format(" (shot {})", name_of_shot(shots, camera.worst_shot)));
    if (camera.edge_texels > 0.0) text += fmt::format(", edges {:.1f} texels wide", camera.edge_texels);
    text += "\n";
    text +=
        fmt::format("  lens   {}, {:.1f} degrees across, focal length {:.2f} x {:.2f} texels, +-{:.3f} %\n",
                    model_name(camera.view), field(camera.view), camera.view.focal.x * camera.view.size.width,
                    camera.view.focal.y * camera.view.size.height, 100.0 * camera.focal_deviation);
    if (!camera.joined) {
      text += "  pose   as in the rig file\n";
      continue;
    }
    const Vec3 mm = 1000.0 * camera.position_m;
    if (camera.turn_deviation_deg == 0.0) {
      text += "  pose   as in the rig file: the others are turned against it";
    } else {
      text += fmt::format("  pose   turned by {:.3f} degrees from the rig file's, +-{:.3f}",
                          degrees_off(camera, rig.views[c]), camera.turn_deviation_deg);
    }
    text += fmt::format("; at {:.1f}, {:.1f}, {:.1f} mm", mm.x, mm.y, mm.z);
    if (camera.place_deviation_m > 0.0) text += fmt::format(", +-{:.1f}", 1000.0 * camera.place_deviation_m);
    text += "\n";
  }
  for (const SeamCalibration& seam : calibration.seams) {
    text += fmt::format("seam {}, {}: {:.2f} texels expected, {:.2f} at most\n",
                        rig.views[static_cast<std::size_t>(seam.a)].name,
                        rig.views[static_cast<std::size_t>(seam.b)].name, seam.rms, seam.worst);
  }
  for (const LeftOutShot& shot : calibration.left_out) {
    text += fmt::format("shot {}: left out, off by {:.2f} texels in {}\n", name_of_shot(shots, shot.shot),
                        shot.rms, rig.views[static_cast<std::size_t>(shot.camera)].name);
  }
  return text;
}

std::string calibration_json(const RigCalibration& calibration, const Rig& rig,
                             std::span<const std::string> shots) {
  using Json = nlohmann::ordered_json;
  Json all = {{"cameras", Json::array()}, {"seams", Json::array()}, {"left_out", Json::array()}};
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const CameraCalibration& camera = calibration.cameras[c];
    Json one = {{"view", camera.view.name}, {"calibrated", camera.has_lens}, {"posed", camera.joined}};
    one["shots"] = camera.shots;
    if (camera.has_lens) {
      const View& view = camera.view;
      one["rms_texels"] = camera.rms;
      one["worst_texels"] = camera.worst;
      if (camera.worst_shot >= 0) one["worst_shot"] = name_of_shot(shots, camera.worst_shot);
      one["edge_texels"] = camera.edge_texels;
      one["model"] = model_name(view);
      one["focal_texels"] = {view.focal.x * view.size.width, view.focal.y * view.size.height};
      one["focal_deviation"] = camera.focal_deviation;
    }
    if (camera.joined) {
      one["turned_deg"] = degrees_off(camera, rig.views[c]);
      one["turn_deviation_deg"] = camera.turn_deviation_deg;
      one["position_m"] = {camera.position_m.x, camera.position_m.y, camera.position_m.z};
      one["position_deviation_m"] = camera.place_deviation_m;
    }
    all["cameras"].push_back(one);
  }
  for (const SeamCalibration& seam : calibration.seams) {
    all["seams"].push_back({{"views",
                             {rig.views[static_cast<std::size_t>(seam.a)].name,
                              rig.views[static_cast<std::size_t>(seam.b)].name}},
                            {"rms_texels", seam.rms},
                            {"worst_texels", seam.worst}});
  }
  for (const LeftOutShot& shot : calibration.left_out) {
    all["left_out"].push_back({{"shot", name_of_shot(shots, shot.shot)},
                               {"view", rig.views[static_cast<std::size_t>(shot.camera)].name},
                               {"rms_texels", shot.rms}});
  }
  all["troubles"] = calibration.troubles;
  return all.dump(2) + "\n";
}

}  // namespace cupola
