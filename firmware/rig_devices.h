// The hardware of an installation: the tables of its rig file that are not about pictures.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/player_command.h"
#include "firmware/rig_cameras.h"
#include "hal/display/kms_mode.h"
#include "hal/gpio/gpio.h"
#include "pipeline/source/exposure_drive.h"
#include "pipeline/source/rig_sync.h"

namespace cupola {

enum class OutputIs : std::uint8_t { kLamp, kShutter, kCameraTrigger, kTally };

struct PanelInput {
  std::optional<PlayerCommand> press;  // none: a blackout, for as long as the line is active
  GpioLine line;
};

struct PanelOutput {
  OutputIs is = OutputIs::kLamp;
  GpioLine line;
};

struct GpioSettings {
  std::vector<PanelInput> inputs;
  std::vector<PanelOutput> outputs;
  bool empty() const { return inputs.empty() && outputs.empty(); }
};

struct ProjectorSettings {
  std::string card;       // "/dev/dri/card1"; empty: the first that has the connector
  std::string connector;  // "HDMI-A-1"; empty: the first that has a projector
  KmsModeWish mode;
  bool nv12 = false;  // format = "NV12": live pictures as they are, without conversion, where it takes them
};

// How the cameras become one picture.
struct LiveSettings {
  SyncSettings sync;                       // [sync]
  bool align = false;                      // align = "slow": frame times are nudged until all capture at once
  bool match_colours = false;              // [colour] match = "slow"
  std::optional<ExposureLimits> exposure;  // [exposure] drive = "together"; none: each camera's own affair
  bool nv12 = false;                       // as the projector's
};

struct RigDevices {
  std::vector<RigCamera> cameras;
  LiveSettings live;
  GpioSettings gpio;
  ProjectorSettings projector;
};

// Reads what load_rig() passes over in the same file; throws InputError naming file, line and key.
// `overrides` are "key=value" lines laid over the file.
// With `errors` they are gathered there.
RigDevices load_rig_devices(const std::filesystem::path& file, std::span<const std::string> overrides = {},
                            SettingsErrors* errors = nullptr);

}  // namespace cupola
