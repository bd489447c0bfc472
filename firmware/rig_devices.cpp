// Reading a rig's hardware into values that cannot be invalid.
// SPDX-License-Identifier: MIT
#include "firmware/rig_devices.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <string_view>

#include "pipeline/frame/error.h"
#include "pipeline/settings/settings.h"

namespace cupola {
namespace {

constexpr std::size_t kMostCues = 9999;  // that a button can name
constexpr std::array<std::string_view, 2> kSlowly = {"off", "slow"};
constexpr std::array<std::string_view, 2> kScanouts = {"XRGB8888", "NV12"};

// The keys that inputs and outputs share.
GpioLine read_line(SettingsTable& table) {
  GpioLine line;
  if (table.has("offset")) {
    if (table.has("name")) {
      table.refuse("name", "expected either a line's name or chip and offset, not both");
      table.may_have({"name"});
    }
    line.offset = static_cast<int>(table.integer("offset", 0, 65535));
    line.chip = table.text("chip");
  } else {
    line.name = table.text("name");
    if (line.name.empty()) table.refuse("name", "expected the name of a line");
    line.chip = table.text("chip", "");
  }
  line.active_low = table.flag("active_low", false);
  return line;
}

// A rig's buttons serve many shows, whose cues have other names.
PlayerCommand parse_cue_number(const std::string& text) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 1 || number > kMostCues) {
    throw InputError(
        fmt::format("cue: expected the number of a cue, from 1 to {}, not \"{}\"", kMostCues, text));
  }
  return {.action = PlayerAction::kCue, .cue = number - 1};
}

std::optional<PlayerCommand> read_press(SettingsTable& table) {
  const std::string word(command_words()[table.choice("does", command_words())]);
  const bool given = table.has("argument");
  const std::string argument = table.text("argument", "");
  if (table.refused("does") || table.refused("argument")) return std::nullopt;
  if (word == "blackout") {  // the line's level, no command
    if (given) table.refuse("argument", "expected none: the picture is black while the line is active");
    return std::nullopt;
  }
  try {
    return word == "cue" ? parse_cue_number(argument) : parse_command(word, argument, {});
  } catch (const InputError& error) {
    table.refuse("argument", given ? error.what() : fmt::format("missing; {}", error.what()));
    return std::nullopt;
  }
}

PanelInput read_input(SettingsTable& table) {
  constexpr std::array<std::string_view, 4> kBias = {"as-is", "none", "pull-up", "pull-down"};
  PanelInput input;
  input.line = read_line(table);
  input.press = read_press(table);
  input.line.bias = static_cast<GpioBias>(table.choice("bias", kBias, 0));
  const double debounce_ms = table.number("debounce_ms", 0.0, 1000.0, 5.0);
  input.line.debounce = std::chrono::microseconds(std::llround(1000.0 * debounce_ms));
  if (input.press) {
    input.line.edges = GpioEdges::kToActive;
  } else {
    // Dark at the first sign: a spike costs a dark frame, waiting for the contacts would cost a bright one.
    input.line.debounce_kind = GpioDebounce::kAtOnce;
  }
  table.finish();
  return input;
}

PanelOutput read_output(SettingsTable& table) {
  constexpr std::array<std::string_view, 4> kIs = {"lamp", "shutter", "camera-trigger", "tally"};
  PanelOutput output;
  output.line = read_line(table);
  output.line.output = true;
  output.is = static_cast<OutputIs>(table.choice("is", kIs));
  table.finish();
  return output;
}

GpioSettings read_gpio(SettingsTable table) {
  GpioSettings gpio;
  std::vector<std::string> taken;
  const auto own = [&](const SettingsTable& entry, const GpioLine& line) {
    if (entry.refused("name") || entry.refused("offset") || entry.refused("chip")) return;
    const std::string what =
        line.offset < 0 && !line.chip.empty() ? line.chip + " " + line.name : describe(line);
    for (const std::string& other : taken) {
      if (other == what) {
        entry.refuse(line.offset < 0 ? "name" : "offset",
                     fmt::format("expected a line of its own; {} is taken", describe(line)));
      }
    }
    taken.push_back(what);
    if (taken.size() > kMostGpioLines) {
      entry.refuse("", fmt::format("expected at most {} inputs and outputs", kMostGpioLines));
    }
  };
  for (SettingsTable& entry : table.tables("input")) {
    gpio.inputs.push_back(read_input(entry));
    own(entry, gpio.inputs.back().line);
  }
  for (SettingsTable& entry : table.tables("output")) {
    gpio.outputs.push_back(read_output(entry));
    own(entry, gpio.outputs.back().line);
  }
  table.finish();
  return gpio;
}

void read_sync(SettingsTable table, LiveSettings& live) {
  SyncSettings& sync = live.sync;
  const auto milliseconds = [&](const char* key, double least, double most,
                                std::chrono::nanoseconds fallback) {
    const double value = table.number(key, least, most, 1e-6 * static_cast<double>(fallback.count()));
    return std::chrono::nanoseconds(std::llround(1e6 * value));
  };
  sync.tolerance = milliseconds("tolerance_ms", 0.01, 1000.0, sync.tolerance);
  sync.patience = milliseconds("patience_ms", 0.0, 3'600'000.0, sync.patience);
  live.align = table.choice("align", kSlowly, 0) == 1;
  table.finish();
}

// [exposure]. Cameras are then set to be told.
std::optional<ExposureLimits> read_exposure(SettingsTable table, std::vector<RigCamera>& cameras) {
  constexpr std::array<std::string_view, 2> kDrives = {"off", "together"};
  const bool together = table.choice("drive", kDrives, 0) == 1;
  ExposureLimits limits;
  limits.brightness = table.number("brightness", 0.05, 0.9, limits.brightness);
  limits.shortest_us = table.number("shortest_us", 1.0, 1e6, limits.shortest_us);
  limits.longest_us = table.number("longest_us", limits.shortest_us, 1e6, limits.longest_us);
  limits.most_gain = table.number("most_gain", 1.0, 1000.0, limits.most_gain);
  std::vector<CameraControl> begins = {{"auto_exposure", 0.0}, {"exposure", limits.longest_us}};
  if (limits.most_gain > 1.0) begins.push_back({"gain", 1.0});
  for (RigCamera& camera : cameras) {
    if (!together) break;
    if (const double rate = camera.setup.rate; rate > 0.0 && limits.longest_us > 1e6 / rate) {
      table.refuse("longest_us",
                   fmt::format("expected at most {:.0f}, a frame's time of the camera of view {}",
                               std::floor(1e6 / rate), camera.view));
    }
    std::vector<CameraControl>& own = camera.setup.controls;
    for (const CameraControl& begin : begins) {
      if (std::ranges::any_of(own,
                              [&](const CameraControl& control) { return control.name == begin.name; })) {
        table.refuse("drive",
                     fmt::format("expected off, or no {} among the controls of the camera of view {}",
                                 begin.name, camera.view));
      }
      own.push_back(begin);
    }
  }
  table.finish();
  return together ? std::optional(limits) : std::nullopt;
}

// [colour]
bool read_match(SettingsTable table, std::span<const RigCamera> cameras) {
  const bool slow = table.choice("match", kSlowly, 0) == 1;
  const auto rgb = std::find_if(cameras.begin(), cameras.end(),
                                [](const RigCamera& camera) { return sends_rgb_only(camera.setup); });
  if (slow && rgb != cameras.end()) {
    table.refuse("match", fmt::format("expected off, or a YUV format for the camera of view {}", rgb->view));
  }
  table.finish();
  return slow;
}

ProjectorSettings read_projector(SettingsTable table) {
  ProjectorSettings projector;
  projector.card = table.text("card", "");
  projector.connector = table.text("connector", "");
  const std::optional<KmsModeWish> mode = parse_kms_mode(table.text("mode", ""));
  if (!mode) table.refuse("mode", "expected a mode like \"1920x1200@60\" or \"1920x1200\"");
  if (mode) projector.mode = *mode;
  projector.nv12 = table.choice("format", kScanouts, 0) == 1;
  table.finish();
  return projector;
}

}  // namespace

RigDevices load_rig_devices(const std::filesystem::path& file, std::span<const std::string> overrides,
                            SettingsErrors* errors) {
  SettingsTable table = load_settings(file, overrides, errors);
  std::vector<std::string> views;
  bool named = true;
  for (SettingsTable& view : table.tables("view")) {
    views.push_back(view.text("name"));
    named = named && !view.refused("name");
  }
  if (!named) views.clear();
  RigDevices devices;
  devices.cameras = read_cameras(table, views);
  devices.live.match_colours = read_match(table.table("colour"), devices.cameras);
  devices.live.exposure = read_exposure(table.table("exposure"), devices.cameras);
  read_sync(table.table("sync"), devices.live);
  devices.projector = read_projector(table.table("display"));
  devices.live.nv12 = devices.projector.nv12;
  devices.gpio = read_gpio(table.table("gpio"));
  return devices;  // unknown keys beside these tables were load_rig()'s to refuse
}

}  // namespace cupola
