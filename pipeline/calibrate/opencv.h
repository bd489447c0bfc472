// What OpenCV does for calibration: finding boards, and a first guess at a camera. Where it was found when
// this was built.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pipeline/calibrate/board.h"
#include "pipeline/calibrate/pose.h"
#include "pipeline/calibrate/sighting.h"
#include "pipeline/frame/image.h"

namespace cupola {

bool have_opencv();

// Fills corners and edge_texels; false when the whole board is not in the picture. May be called from several
// threads.
bool find_board(const Image& picture, const Board& board, Sighting& sighting);

struct CameraGuess {
  View view;                 // focal, principal, distortion, coefficients
  std::vector<Pose> boards;  // of each sighting, in the camera's axes (OpenCV's)
};
// From all sightings of one camera whose pictures have `size`; none where OpenCV finds no such lens.
std::optional<CameraGuess> guess_camera(std::span<const Sighting* const> sightings, const Board& board,
                                        Size size, Distortion model);

}  // namespace cupola
