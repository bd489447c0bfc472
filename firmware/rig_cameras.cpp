// Reading [[camera]].
// SPDX-License-Identifier: MIT
#include "firmware/rig_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "pipeline/source/live_faces.h"

namespace cupola {
namespace {

constexpr double kMostTexels = 65535.0;

std::vector<CameraFormat> read_formats(SettingsTable& table) {
  std::vector<CameraFormat> formats;
  if (!table.has("formats")) return formats;
  for (const std::string& name : table.texts("formats", 1, 16)) {
    CameraFormat format{};
    if (!format_of(name, format)) {
      table.refuse(
          "formats",
          fmt::format(
              "expected YUYV, UYVY, NV12, P010, YU12, 422P, RGB3, BGR3, XR24, GREY or MJPG, not \"{}\"",
              name));
    }
    formats.push_back(format);
  }
  return formats;
}

// Whole numbers from `least` to 65535.
std::vector<int> read_texels(SettingsTable& table, std::string_view key, std::span<const int> least) {
  std::vector<int> whole;
  for (const double number : table.numbers(key, least.size(), least.size())) {
    if (!(number >= least[whole.size()] && number <= kMostTexels && number == std::floor(number))) {
      table.refuse(key,
                   fmt::format("expected whole numbers of texels, from {} to 65535", least[whole.size()]));
      return {least.begin(), least.end()};
    }
    whole.push_back(static_cast<int>(number));
  }
  return whole;
}

// gains = [r, g, b] and black, in 8-bit steps: a sample x comes out as gain (x - black).
std::optional<ViewColour> read_colour(SettingsTable& table) {
  const double black = table.number("black", -32.0, 32.0, 0.0);
  if (!table.has("gains") && !table.has("black")) return std::nullopt;
  ViewColour colour;
  const std::vector<double> gains =
      table.has("gains") ? table.numbers("gains", 3, 3) : std::vector{1.0, 1.0, 1.0};
  for (std::size_t c = 0; c < 3; ++c) {
    if (!(gains[c] >= ViewColour::kLeastGain && gains[c] <= ViewColour::kMostGain)) {
      table.refuse("gains", fmt::format("expected [red, green, blue], each from {} to {}",
                                        ViewColour::kLeastGain, ViewColour::kMostGain));
      return std::nullopt;
    }
    colour.gain[c] = gains[c];
    colour.offset[c] = -gains[c] * black;
  }
  return colour;
}

RigCamera read_camera(SettingsTable& table, std::span<const std::string> views) {
  RigCamera camera;
  camera.view = table.text("view");
  if (!views.empty() && std::find(views.begin(), views.end(), camera.view) == views.end()) {
    const std::vector<std::string_view> names(views.begin(), views.end());
    const std::string_view nearest = nearest_name(camera.view, names);
    table.refuse("view",
                 fmt::format("expected the name of one of this rig's views, not \"{}\"{}", camera.view,
                             nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest)));
  }
  constexpr std::array<std::string_view, 3> kDrivers = {"v4l2", "libcamera", "fake"};
  camera.driver = static_cast<CameraDriver>(table.choice("driver", kDrivers, 0));
  CameraSetup& setup = camera.setup;
  setup.device = table.text("device");
  if (setup.device.empty()) table.refuse("device", "expected a path, bus, card or id: see cupola devices");
  setup.formats = read_formats(table);
  if (table.has("size")) {
    constexpr std::array<int, 2> kLeast = {1, 1};
    const std::vector<int> size = read_texels(table, "size", kLeast);
    setup.width = size[0];
    setup.height = size[1];
  }
  if (table.has("crop")) {
    constexpr std::array<int, 4> kLeast = {0, 0, 1, 1};
    const std::vector<int> crop = read_texels(table, "crop", kLeast);
    setup.crop = {crop[0], crop[1], crop[2], crop[3]};
  }
  setup.rate = table.number("rate", 0.01, 1000.0, 0.0);
  setup.buffers = static_cast<int>(table.integer("buffers", 2, 32, setup.buffers));
  camera.patience = std::chrono::milliseconds(table.integer("patience_ms", 20, 60'000, 500));
  camera.colour = read_colour(table);
  if (camera.colour && sends_rgb_only(setup)) {
    table.refuse(table.has("gains") ? "gains" : "black", "expected a YUV format beside it, as NV12 or YUYV");
  }
  SettingsTable controls = table.table("controls");
  for (const std::string& name : controls.keys()) {
    setup.controls.push_back({name, controls.number(name, -1e15, 1e15)});
  }
  controls.finish();
  table.finish();
  return camera;
}

}  // namespace

bool sends_rgb_only(const CameraSetup& setup) {
  return !setup.formats.empty() &&
         std::all_of(setup.formats.begin(), setup.formats.end(), [](CameraFormat format) {
           const auto layout = layout_of(format);
           return layout && is_rgb(*layout);
         });
}

std::vector<RigCamera> read_cameras(SettingsTable& rig, std::span<const std::string> views) {
  std::vector<RigCamera> cameras;
  std::set<std::string> filled;
  std::set<std::string> devices;
  for (SettingsTable& table : rig.tables("camera")) {
    RigCamera camera = read_camera(table, views);
    if (!filled.insert(camera.view).second && !table.refused("view")) {
      table.refuse("view",
                   fmt::format("expected a view of its own, but {} has a camera already", camera.view));
    }
    if (!devices.insert(camera.setup.device).second && !table.refused("device")) {
      table.refuse("device", fmt::format("expected a device of its own, but {} fills another view",
                                         camera.setup.device));
    }
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

}  // namespace cupola
