// libcamera's headers, and everything in which its versions differ: 0.0.3 (Debian 12) to 0.7.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>

#include <libcamera/camera.h>
#include <libcamera/camera_manager.h>
#include <libcamera/control_ids.h>
#include <libcamera/controls.h>
#include <libcamera/formats.h>
#include <libcamera/framebuffer.h>
#include <libcamera/framebuffer_allocator.h>
#include <libcamera/property_ids.h>
#include <libcamera/request.h>
#include <libcamera/stream.h>
#include <libcamera/version.h>

#define CUPOLA_LIBCAMERA_VERSION \
  (LIBCAMERA_VERSION_MAJOR * 10000 + LIBCAMERA_VERSION_MINOR * 100 + LIBCAMERA_VERSION_PATCH)

namespace cupola {

// Roles were a vector of their own type before 0.1 and are a span since; a braced list is both.
inline std::unique_ptr<libcamera::CameraConfiguration> generate_configuration(libcamera::Camera& camera,
                                                                              libcamera::StreamRole role) {
  return camera.generateConfiguration({role});
}

// Strings among the properties became views in 0.7.
inline std::string model_of(const libcamera::Camera& camera) {
  const auto model = camera.properties().get(libcamera::properties::Model);
  return model ? std::string(*model) : std::string();
}

// A frame with time and sequence but no picture worth showing, as the sensor starts: told since 0.5.
inline bool is_startup(libcamera::FrameMetadata::Status status) {
#if CUPOLA_LIBCAMERA_VERSION >= 500
  return status == libcamera::FrameMetadata::FrameStartup;
#else
  static_cast<void>(status);
  return false;
#endif
}

// Whether the camera has the control. ControlInfoMap::count() by number is no answer: it counts those that
// libcamera has.
inline bool has_control(const libcamera::ControlInfoMap& known, const libcamera::ControlId& id) {
  return known.find(&id) != known.end();
}

// Whether a control wants several numbers. Ids say so themselves since 0.4. The library ends the program when
// such a control is given one number.
inline bool is_array(const libcamera::ControlId& id) {
#if CUPOLA_LIBCAMERA_VERSION >= 400
  return id.isArray();
#else
  using namespace libcamera::controls;
  for (const unsigned int known :
       {COLOUR_GAINS, COLOUR_CORRECTION_MATRIX, SENSOR_BLACK_LEVELS, FRAME_DURATION_LIMITS, AF_WINDOWS}) {
    if (id.id() == known) return true;
  }
  return false;
#endif
}

// The number as a control of that type takes it; none when it takes no single number.
inline libcamera::ControlValue control_value(const libcamera::ControlId& id, double number) {
  using libcamera::ControlValue;
  if (is_array(id)) return {};
  switch (id.type()) {
    case libcamera::ControlTypeBool:
      return ControlValue(number != 0.0);
    case libcamera::ControlTypeByte:
      return ControlValue(static_cast<std::uint8_t>(number));
    case libcamera::ControlTypeInteger32:
      return ControlValue(static_cast<std::int32_t>(number));
    case libcamera::ControlTypeInteger64:
      return ControlValue(static_cast<std::int64_t>(number));
    case libcamera::ControlTypeFloat:
      return ControlValue(static_cast<float>(number));
#if CUPOLA_LIBCAMERA_VERSION >= 400
    case libcamera::ControlTypeUnsigned16:
      return ControlValue(static_cast<std::uint16_t>(number));
    case libcamera::ControlTypeUnsigned32:
      return ControlValue(static_cast<std::uint32_t>(number));
#endif
    default:
      return {};
  }
}

// Takes what is fixed by hand from the automatic exposure. Since 0.5 exposure time and gain have a mode each;
// before, both are automatic or neither, and one that is given is kept to by the automatic for the other.
inline void fix_by_hand(libcamera::ControlList& controls, const libcamera::ControlInfoMap& known,
                        bool exposure, bool gain) {
  namespace id = libcamera::controls;
  if (controls.contains(id::AeEnable.id())) return;  // was said
#if CUPOLA_LIBCAMERA_VERSION >= 500
  if (exposure && has_control(known, id::ExposureTimeMode)) {
    controls.set(id::ExposureTimeMode, id::ExposureTimeModeManual);
  }
  if (gain && has_control(known, id::AnalogueGainMode)) {
    controls.set(id::AnalogueGainMode, id::AnalogueGainModeManual);
  }
#else
  if (exposure && gain && has_control(known, id::AeEnable)) controls.set(id::AeEnable, false);
#endif
}

}  // namespace cupola
