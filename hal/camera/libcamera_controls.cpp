// Names to control ids, units to libcamera's.
// SPDX-License-Identifier: MIT
#include "hal/camera/libcamera_controls.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace cupola {

namespace {

namespace ids = libcamera::controls;

CameraTrouble unsupported(const char* step) {
  return {CameraCause::kUnsupported, step, 0};
}

struct OwnName {
  std::string_view name;
  const libcamera::ControlId& id;
};

const libcamera::ControlId* find_control(const libcamera::ControlInfoMap& known, std::string_view name) {
  const OwnName own_names[] = {
      {"exposure", ids::ExposureTime},  // microseconds too
      {"gain", ids::AnalogueGain},
      {"white_balance", ids::ColourTemperature},  // read-only before 0.5, and then not among the known
      {"auto_exposure", ids::AeEnable},
      {"auto_white_balance", ids::AwbEnable},
  };
  for (const OwnName& own : own_names) {
    if (name == own.name) return has_control(known, own.id) ? &own.id : nullptr;
  }
  for (const auto& [id, info] : known) {
    if (id->name() == name) return id;
  }
  return nullptr;
}

std::optional<CameraTrouble> set_named(const CameraSetup& setup, const libcamera::ControlInfoMap& known,
                                       libcamera::ControlList& controls) {
  bool exposure = false;
  bool gain = false;
  bool white = false;
  std::optional<float> red;
  std::optional<float> blue;
  for (const CameraControl& control : setup.controls) {
    if (!std::isfinite(control.value) || std::abs(control.value) > 1e15)
      return unsupported("control's value");
    if (control.name == "ColourGains.red") {
      red = static_cast<float>(control.value);
      continue;
    }
    if (control.name == "ColourGains.blue") {
      blue = static_cast<float>(control.value);
      continue;
    }
    if (control.name == "trigger") {
      if (control.value != 0.0) return unsupported("trigger");
      continue;
    }
    const libcamera::ControlId* id = find_control(known, control.name);
    if (!id) return unsupported("control's name");
    const libcamera::ControlValue value = control_value(*id, control.value);
    if (value.isNone()) return unsupported("control's type");
    controls.set(id->id(), value);
    exposure |= id->id() == ids::ExposureTime.id();
    gain |= id->id() == ids::AnalogueGain.id();
    white |= id->id() == ids::ColourTemperature.id();
  }
  if (red || blue) {
    if (!red || !blue || !has_control(known, ids::ColourGains)) return unsupported("ColourGains");
    controls.set(ids::ColourGains, {*red, *blue});
    white = true;
  }
  fix_by_hand(controls, known, exposure, gain);
  if (white && has_control(known, ids::AwbEnable) && !controls.contains(ids::AwbEnable.id())) {
    controls.set(ids::AwbEnable, false);
  }
  return std::nullopt;
}

// Frames a second; 0 where the camera's rate is its own affair.
double set_rate(double rate, const libcamera::ControlInfoMap& known, libcamera::ControlList& controls) {
  const auto limits = known.find(&ids::FrameDurationLimits);
  if (rate <= 0.0 || limits == known.end()) return 0.0;
  double microseconds = 1e6 / rate;
  const libcamera::ControlValue& shortest = limits->second.min();
  const libcamera::ControlValue& longest = limits->second.max();
  if (shortest.type() == libcamera::ControlTypeInteger64 && !shortest.isArray() && !longest.isArray() &&
      longest.type() == libcamera::ControlTypeInteger64) {
    const auto least = static_cast<double>(shortest.get<std::int64_t>());
    const auto most = static_cast<double>(longest.get<std::int64_t>());
    if (least > 0.0 && least <= most) microseconds = std::clamp(microseconds, least, most);
  }
  const auto duration = static_cast<std::int64_t>(std::lround(std::min(microseconds, 1e9)));
  controls.set(ids::FrameDurationLimits, {duration, duration});
  // The rate that was asked for, where it is kept to the microsecond.
  return std::abs(1e6 / rate - microseconds) < 0.5 ? rate : 1e6 / microseconds;
}

}  // namespace

bool set_control(const CameraControl& control, const libcamera::Camera& camera,
                 libcamera::ControlList& controls) {
  const libcamera::ControlInfoMap& known = camera.controls();
  if (control.name == "frame_time") return set_rate(1e6 / control.value, known, controls) > 0.0;
  CameraSetup setup;
  setup.controls = {control};
  return !set_named(setup, known, controls);
}

namespace {

CameraArea area_of(const libcamera::Rectangle& area) {
  return {area.x, area.y, static_cast<int>(area.width), static_cast<int>(area.height)};
}

// What `wanted` and `whole` have in common; width 0: nothing.
CameraArea common_area(const CameraArea& wanted, const CameraArea& whole) {
  const int left = std::max(wanted.x, whole.x);
  const int top = std::max(wanted.y, whole.y);
  const int right = std::min(wanted.x + wanted.width, whole.x + whole.width);
  const int bottom = std::min(wanted.y + wanted.height, whole.y + whole.height);
  if (right <= left || bottom <= top) return {};
  return {left, top, right - left, bottom - top};
}

// Depends on the sensor's mode, so it is known only when the camera is configured. Width 0: unknown.
CameraArea sensor_area(const libcamera::Camera& camera) {
  const auto whole = camera.properties().get(libcamera::properties::ScalerCropMaximum);
  return whole ? area_of(*whole) : CameraArea{};
}

bool can_crop(const libcamera::Camera& camera) {
  const CameraArea whole = sensor_area(camera);
  return whole.width > 0 && whole.height > 0 && has_control(camera.controls(), ids::ScalerCrop);
}

int texels_of(int part, int whole, int texels) {
  return static_cast<int>(std::lround(static_cast<double>(part) * texels / whole));
}

}  // namespace

std::optional<CameraArea> size_of_crop(const CameraSetup& setup, const libcamera::Camera& camera,
                                       const CameraMode& whole) {
  if (setup.crop.width <= 0 || !can_crop(camera)) return std::nullopt;
  const CameraArea sensor = sensor_area(camera);
  const CameraArea crop = common_area(setup.crop, sensor);
  if (crop.width == 0) return std::nullopt;
  return CameraArea{0, 0, texels_of(crop.width, sensor.width, whole.width),
                    texels_of(crop.height, sensor.height, whole.height)};
}

std::optional<CameraTrouble> set_controls(const CameraSetup& setup, const libcamera::Camera& camera,
                                          libcamera::ControlList& controls, CameraMode& mode) {
  const libcamera::ControlInfoMap& known = camera.controls();
  if (auto trouble = set_named(setup, known, controls)) return trouble;
  mode.rate = set_rate(setup.rate, known, controls);

  const CameraArea sensor = sensor_area(camera);
  mode.crop = sensor.width > 0 && sensor.height > 0 ? sensor : CameraArea{0, 0, mode.width, mode.height};
  if (setup.crop.width > 0 && can_crop(camera)) {
    const CameraArea crop = common_area(setup.crop, mode.crop);
    if (crop.width == 0) return unsupported("ScalerCrop");
    controls.set(ids::ScalerCrop, libcamera::Rectangle(crop.x, crop.y, static_cast<unsigned int>(crop.width),
                                                       static_cast<unsigned int>(crop.height)));
    mode.crop = crop;
  }
  return std::nullopt;
}

}  // namespace cupola
