// Finds each control, turns the value into the driver's unit and sets it.
// SPDX-License-Identifier: MIT
#include "hal/camera/v4l2_controls.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>

namespace cupola {

namespace {

constexpr int kMostControls = 1024;  // that a driver can list

enum class Unit : std::uint8_t { kDrivers, kExposure, kGain, kOnOff, kAutoExposure };

struct KnownControl {
  const char* name;
  __u32 id;  // 0: to be found by its name
  Unit unit;
  bool automatic;
};

constexpr std::array<KnownControl, 7> kKnown = {{
    {"auto_exposure", V4L2_CID_EXPOSURE_AUTO, Unit::kAutoExposure, true},
    {"auto_white_balance", V4L2_CID_AUTO_WHITE_BALANCE, Unit::kOnOff, true},
    {"exposure", V4L2_CID_EXPOSURE_ABSOLUTE, Unit::kExposure, false},
    {"gain", V4L2_CID_ANALOGUE_GAIN, Unit::kGain, false},
    {"gain", V4L2_CID_GAIN, Unit::kGain, false},
    {"white_balance", V4L2_CID_WHITE_BALANCE_TEMPERATURE, Unit::kDrivers, false},
    {"trigger", 0, Unit::kOnOff, false},
}};

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}
bool is_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
}

// As v4l2-ctl does: lower case, whatever is between words is one underscore.
std::string plain(std::string_view name) {
  std::string text;
  for (const char c : name) {
    if (is_word(lower(c))) {
      text += lower(c);
    } else if (!text.empty() && text.back() != '_') {
      text += '_';
    }
  }
  while (!text.empty() && text.back() == '_') text.pop_back();
  return text;
}

int query(const V4l2Node& node, __u32 id, v4l2_query_ext_ctrl& found) noexcept {
  found = {};
  found.id = id;
  return node.ask(VIDIOC_QUERY_EXT_CTRL, &found);
}

// Goes through all of the driver's controls; 0 and the first that `is_meant`.
template <class Meant>
int find(const V4l2Node& node, v4l2_query_ext_ctrl& found, Meant is_meant) {
  __u32 last = 0;
  for (int i = 0; i < kMostControls; ++i) {
    if (const int error = query(node, last | V4L2_CTRL_FLAG_NEXT_CTRL, found)) return error;
    if (is_meant(std::string_view(found.name, strnlen(found.name, sizeof(found.name))))) return 0;
    last = found.id;
  }
  return EINVAL;
}

int set(const V4l2Node& node, const v4l2_query_ext_ctrl& found, std::int64_t value) noexcept {
  v4l2_ext_control control{};
  control.id = found.id;
  if (found.type == V4L2_CTRL_TYPE_INTEGER64) {
    control.value64 = value;
  } else {
    control.value = static_cast<__s32>(value);
  }
  v4l2_ext_controls controls{};
  controls.which = V4L2_CTRL_WHICH_CUR_VAL;
  controls.count = 1;
  controls.controls = &control;
  return node.ask(VIDIOC_S_EXT_CTRLS, &controls);
}

bool is_number(__u32 type) {
  switch (type) {
    case V4L2_CTRL_TYPE_INTEGER:
    case V4L2_CTRL_TYPE_BOOLEAN:
    case V4L2_CTRL_TYPE_MENU:
    case V4L2_CTRL_TYPE_BUTTON:
    case V4L2_CTRL_TYPE_INTEGER64:
    case V4L2_CTRL_TYPE_BITMASK:
    case V4L2_CTRL_TYPE_INTEGER_MENU:
      return true;
    default:
      return false;
  }
}

enum class Beyond : std::uint8_t { kRefused, kNearest };  // what becomes of values that a control has not

// errno, or 0. ERANGE for values that are refused.
int set_value(const V4l2Node& node, const v4l2_query_ext_ctrl& found, Unit unit, double value,
              Beyond beyond) noexcept {
  if (!is_number(found.type) || (found.flags & V4L2_CTRL_FLAG_DISABLED) != 0) return EINVAL;
  if (unit == Unit::kAutoExposure) {
    // Drivers have one or the other of each.
    const std::array<int, 2> automatic = {V4L2_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY};
    const std::array<int, 2> manual = {V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_SHUTTER_PRIORITY};
    const auto& choices = value != 0.0 ? automatic : manual;
    const int error = set(node, found, choices[0]);
    return error == EINVAL || error == ERANGE ? set(node, found, choices[1]) : error;
  }
  if (unit == Unit::kExposure) value /= 100.0;  // V4L2 counts in 100 microseconds
  if (unit == Unit::kGain) {
    if (found.minimum < 1) return ENOTSUP;
    value *= static_cast<double>(found.minimum);
  }
  if (unit == Unit::kOnOff) value = value != 0.0 ? 1.0 : 0.0;
  double rounded = std::round(value);
  const bool is_bits = found.type == V4L2_CTRL_TYPE_BITMASK || found.type == V4L2_CTRL_TYPE_BUTTON;
  const double least = is_bits ? 0.0 : static_cast<double>(found.minimum);
  const double most = is_bits ? 4294967295.0 : static_cast<double>(found.maximum);
  if (beyond == Beyond::kNearest && !std::isnan(rounded)) rounded = std::clamp(rounded, least, most);
  if (!(rounded >= least && rounded <= most)) return ERANGE;
  return set(node, found, static_cast<std::int64_t>(rounded));
}

std::optional<CameraTrouble> outcome(const char* step, int error) noexcept {
  if (error == 0) return std::nullopt;
  CameraTrouble trouble = refused(step, error);
  if (error == EINVAL || error == ERANGE || error == ENOTSUP || error == ENOTTY) {
    trouble.cause = CameraCause::kUnsupported;
  }
  return trouble;
}

std::optional<CameraTrouble> set_one(const V4l2Node& node, const CameraControl& control, Beyond beyond) {
  v4l2_query_ext_ctrl found{};
  int error = EINVAL;
  const KnownControl* meant = nullptr;
  for (const KnownControl& known : kKnown) {
    if (control.name != known.name) continue;
    meant = &known;
    error = known.id != 0 ? query(node, known.id, found) : find(node, found, [](std::string_view name) {
      return plain(name).find("trigger") != std::string::npos;
    });
    if (error == 0) break;
  }
  if (meant) {
    if (error == 0) error = set_value(node, found, meant->unit, control.value, beyond);
    return outcome(meant->name, error);
  }
  error = find(node, found,
               [&](std::string_view name) { return name == control.name || plain(name) == control.name; });
  if (error == 0) error = set_value(node, found, Unit::kDrivers, control.value, beyond);
  return outcome("the driver's control", error);
}

bool is_automatic(const CameraControl& control) {
  for (const KnownControl& known : kKnown) {
    if (control.name == known.name) return known.automatic;
  }
  return false;
}

}  // namespace

std::optional<CameraTrouble> set_controls(const V4l2Node& node, std::span<const CameraControl> controls) {
  for (const bool automatic : {true, false}) {
    for (const CameraControl& control : controls) {
      if (is_automatic(control) != automatic) continue;
      if (const auto trouble = set_one(node, control, Beyond::kRefused)) return trouble;
    }
  }
  return std::nullopt;
}

bool set_nearest_control(const V4l2Node& node, const CameraControl& control) {
  return !set_one(node, control, Beyond::kNearest);
}

}  // namespace cupola
