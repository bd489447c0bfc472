// The hardware of an installation: the tables of its rig file that are not about pictures.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "hal/gpio/gpio.h"

namespace cupola {

enum class InputDoes : std::uint8_t { kPlayPause, kNext, kBlackout };
enum class OutputIs : std::uint8_t { kLamp, kShutter, kCameraTrigger, kTally };

struct PanelInput {
  InputDoes does = InputDoes::kPlayPause;
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

struct RigDevices {
  GpioSettings gpio;
};

// Reads what load_rig() passes over in the same file; throws InputError naming file, line and key.
// `overrides` are "key=value" lines laid over the file.
RigDevices load_rig_devices(const std::filesystem::path& file, std::span<const std::string> overrides = {});

}  // namespace cupola
