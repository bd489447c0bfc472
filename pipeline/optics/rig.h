// A rig: the frame, the lens, the views and the filter of one installation, read from one TOML file.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/optics/filter.h"
#include "pipeline/optics/frame_geometry.h"
#include "pipeline/optics/seam.h"
#include "pipeline/optics/view.h"

namespace cupola {

class SettingsErrors;

struct Rig {
  std::filesystem::path file;
  FrameGeometry frame;
  std::vector<View> views;  // one to six, poses in lens space: -z is the axis of projection
  FilterSettings filter;    // the default one where there is a budget
  SampleSettings samples;
  SeamSettings seams;
  std::optional<double> budget_ms;  // of one frame on this machine, instead of a filter
  double tilt_deg = 0.0;
  Mat3 world_from_lens{1.0};  // Rx(tilt): what sources that draw the world turn a view's pose by
};

// Throws InputError naming file, line and key. `overrides` are "key=value" lines laid over the file. With
// `errors` they are gathered there, and the rig is whole only when it gains none.
Rig load_rig(const std::filesystem::path& file, std::span<const std::string> overrides = {},
             SettingsErrors* errors = nullptr);

// Gives the views the sizes of their pictures; throws InputError where the rig demands another or a view has
// none. Faces of different sizes are fine.
void set_view_sizes(Rig& rig, std::span<const Size> sizes);

}  // namespace cupola
