// libcamera's pixel formats: DRM's FourCCs, whose names tell the bytes from the last to the first.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/camera/camera.h"

namespace cupola {

struct LibcameraFormat {
  CameraFormat format;
  std::uint32_t fourcc;
};

constexpr std::uint32_t fourcc(const char (&name)[5]) {
  std::uint32_t code = 0;
  for (int i = 3; i >= 0; --i) code = code << 8 | static_cast<unsigned char>(name[i]);
  return code;
}

inline constexpr std::array<LibcameraFormat, 10> kLibcameraFormats{{
    {CameraFormat::kYuyv, fourcc("YUYV")},
    {CameraFormat::kUyvy, fourcc("UYVY")},
    {CameraFormat::kNv12, fourcc("NV12")},
    {CameraFormat::kI420, fourcc("YU12")},   // libcamera's YUV420
    {CameraFormat::kI422, fourcc("YU16")},   // libcamera's YUV422
    {CameraFormat::kRgb24, fourcc("BG24")},  // BGR888: R comes first in memory
    {CameraFormat::kBgr24, fourcc("RG24")},  // RGB888
    {CameraFormat::kXrgb32, fourcc("XR24")},
    {CameraFormat::kGrey, fourcc("R8  ")},
    {CameraFormat::kMjpeg, fourcc("MJPG")},
}};

constexpr std::uint32_t libcamera_fourcc(CameraFormat format) {
  for (const LibcameraFormat& known : kLibcameraFormats) {
    if (known.format == format) return known.fourcc;
  }
  return 0;
}

constexpr std::optional<CameraFormat> format_of_libcamera(std::uint32_t code) {
  for (const LibcameraFormat& known : kLibcameraFormats) {
    if (known.fourcc == code) return known.format;
  }
  return std::nullopt;
}

}  // namespace cupola
