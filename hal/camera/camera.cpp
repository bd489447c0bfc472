// Names of formats and of what can go wrong.
// SPDX-License-Identifier: MIT
#include "hal/camera/camera.h"

#include <cassert>
#include <cstring>

namespace cupola {

namespace {

constexpr std::array<const char*, kCameraFormats> kFormatNames = {
    "YUYV", "UYVY", "NV12", "YU12", "422P", "RGB3", "BGR3", "XR24", "GREY", "MJPG", "P010"};
constexpr std::array<const char*, kCameraCauses> kCauseNames = {
    "no such device", "busy: somebody else has it",          "not supported",
    "no signal",      "it sends something else than agreed", "the driver failed",
    "silent",
};

}  // namespace

const char* name_of(CameraFormat format) {
  const auto index = static_cast<std::size_t>(format);
  assert(index < kFormatNames.size());
  return kFormatNames[index];
}

bool format_of(std::string_view name, CameraFormat& format) {
  for (std::size_t i = 0; i < kFormatNames.size(); ++i) {
    if (name == kFormatNames[i]) {
      format = static_cast<CameraFormat>(i);
      return true;
    }
  }
  return false;
}

const char* name_of(CameraCause cause) {
  const auto index = static_cast<std::size_t>(cause);
  assert(index < kCauseNames.size());
  return kCauseNames[index];
}

std::string describe(const CameraTrouble& trouble) {
  std::string text = trouble.step;
  if (!text.empty()) text += ": ";
  text += name_of(trouble.cause);
  if (trouble.error != 0) {
    text += ": ";
    text += std::strerror(trouble.error);
  }
  return text;
}

}  // namespace cupola
