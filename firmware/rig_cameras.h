// The cameras of a rig file: which device fills which view, and how it is to be set.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/camera/camera.h"
#include "pipeline/settings/settings.h"
#include "pipeline/warp/view_colour.h"

namespace cupola {

enum class CameraDriver : std::uint8_t { kV4l2, kLibcamera, kFake };

struct RigCamera {
  std::string view;  // the view that it fills
  CameraDriver driver = CameraDriver::kV4l2;
  CameraSetup setup;
  std::chrono::nanoseconds patience{0};  // the longest silence that is taken for life
  std::optional<ViewColour> colour;      // locked
};

// Whether it may send nothing but RGB, of which no colours are matched or locked. Without formats it may send
// any.
bool sends_rgb_only(const CameraSetup& setup);

// The tables [[camera]] of a rig file, none to one a view of `views`; where `views` is empty they may name
// any. Throws InputError.
std::vector<RigCamera> read_cameras(SettingsTable& rig, std::span<const std::string> views);

}  // namespace cupola
