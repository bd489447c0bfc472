// A rig file's text with other lenses and poses in its views; all else, comments too, stays as it is.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "pipeline/optics/vector.h"

namespace cupola {

// What replaces a view's keys; what is not there leaves them.
struct ViewKeys {
  std::optional<std::string> calibration;  // instead of calibration, fov_deg and fov_y_deg
  std::optional<Vec3> forward;             // with up; in lens space
  Vec3 up{0, 1, 0};
  std::optional<Vec3> position_m;  // in lens space
};

// `text` is that of `file`, a rig that loads; one of `views` for each of its [[view]], in their order. Poses
// are turned by `world_from_lens` where the file's are level with the horizon. Throws InputError where a
// view's keys do not have lines of their own.
std::string rewrite_views(const std::string& text, const std::filesystem::path& file,
                          std::span<const ViewKeys> views, const Mat3& world_from_lens);

}  // namespace cupola
