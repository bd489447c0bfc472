// Our names for formats against libcamera's own.
// SPDX-License-Identifier: MIT
#include "hal/camera/libcamera_format.h"

#include <gtest/gtest.h>

#include "hal/camera/libcamera_version.h"

namespace cupola {
namespace {

TEST(LibcameraFormat, HasTheCodesOfLibcamerasHeaders) {
  namespace formats = libcamera::formats;
  EXPECT_EQ(libcamera_fourcc(CameraFormat::kYuyv), formats::YUYV.fourcc());
  EXPECT_EQ(libcamera_fourcc(CameraFormat::kUyvy), formats::UYVY.fourcc());
  EXPECT_EQ(libcamera_fourcc(CameraFormat::kNv12), formats::NV12.fourcc());
  EXPECT_EQ(libcamera_fourcc(CameraFormat::kI420), formats::YUV420.fourcc());
  EXPECT_EQ(libcamera_fourcc(CameraFormat::kI422), formats::YUV422.fourcc());
  EXPECT_EQ(libcamera_fourcc(CameraFormat::kXrgb32), formats::XRGB8888.fourcc());
  EXPECT_EQ(libcamera_fourcc(CameraFormat::kGrey), formats::R8.fourcc());
  EXPECT_EQ(libcamera_fourcc(CameraFormat::kMjpeg), formats::MJPEG.fourcc());
}

TEST(LibcameraFormat, NamesTheBytesOfAWordFromTheLastToTheFirst) {
  EXPECT_EQ(libcamera_fourcc(CameraFormat::kRgb24), libcamera::formats::BGR888.fourcc());
  EXPECT_EQ(libcamera_fourcc(CameraFormat::kBgr24), libcamera::formats::RGB888.fourcc());
}

TEST(LibcameraFormat, ComesBackFromItsCode) {
  for (const LibcameraFormat& known : kLibcameraFormats) {
    EXPECT_EQ(format_of_libcamera(known.fourcc), known.format);
    EXPECT_EQ(libcamera_fourcc(known.format), known.fourcc);
  }
  EXPECT_EQ(format_of_libcamera(libcamera::formats::SRGGB10.fourcc()), std::nullopt);
}

}  // namespace
}  // namespace cupola
