// Built without OpenCV: boards are not found.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/opencv.h"

namespace cupola {

bool have_opencv() {
  return false;
}

bool find_board(const Image&, const Board&, Sighting&) {
  return false;
}

std::optional<CameraGuess> guess_camera(std::span<const Sighting* const>, const Board&, Size, Distortion) {
  return std::nullopt;
}

}  // namespace cupola
