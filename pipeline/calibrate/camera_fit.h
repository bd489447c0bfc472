// One camera's lens, from its own pictures.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pipeline/calibrate/adjustment.h"

namespace cupola {

struct CameraFit {
  View view;  // the lens alone
  int bends = 5;
  std::vector<const Sighting*> sightings;  // those that agree
  std::vector<Pose> boards;                // of each, in the camera's axes (OpenCV's)
  std::vector<const Sighting*> left_out;   // those that do not
  std::vector<double> left_out_rms;        // texels
  double rms = 0.0;                        // texels
};

// None where no lens of that model fits; `model` none: the better of the two. Of the sightings at least
// three.
std::optional<CameraFit> fit_camera(std::span<const Sighting* const> sightings, const Board& board, Size size,
                                    std::optional<Distortion> model);

double rms_of(const std::vector<Vec2>& residuals);  // of distances

// The sighting that is off so much more than the others that it is none of them: beyond four times the
// median, and beyond 0.4 texels. None when all are alike.
std::optional<std::size_t> stranger(const Adjustment& adjustment);

}  // namespace cupola
