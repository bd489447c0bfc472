// YAML with OpenCV's tags; 12 digits are a millionth of a millionth of the picture.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/calibration_file.h"

#include <fmt/format.h>

#include <algorithm>

namespace cupola {

std::string calibration_text(const View& view, double rms) {
  const double width = view.size.width;
  const double height = view.size.height;
  const bool fisheye = view.distortion == Distortion::kFisheye;
  const std::size_t count = fisheye ? 4 : view.coefficients[5] != 0.0 ? 8 : 5;
  std::string text =
      fmt::format("%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\n", view.size.width, view.size.height);
  if (fisheye) text += "distortion_model: fisheye\n";
  text += "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n";
  // OpenCV's pixel centres are whole numbers, a view's halves.
  text += fmt::format("   data: [ {:#.12g}, 0., {:#.12g}, 0., {:#.12g}, {:#.12g}, 0., 0., 1. ]\n",
                      view.focal.x * width, view.principal.x * width - 0.5, view.focal.y * height,
                      view.principal.y * height - 0.5);
  text += fmt::format("distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: {}\n   dt: d\n", count);
  text += "   data: [";
  for (std::size_t i = 0; i < count; ++i)
    text += fmt::format("{} {:#.12g}", i == 0 ? "" : ",", view.coefficients[i]);
  text += fmt::format(" ]\navg_reprojection_error: {:#.4g}\n", rms);
  return text;
}

}  // namespace cupola
