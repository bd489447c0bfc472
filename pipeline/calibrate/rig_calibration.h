// From sightings of the board to lenses, poses, and how well both are known.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/calibrate/board.h"
#include "pipeline/calibrate/sighting.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"

namespace cupola {

struct CameraCalibration {
  View view;              // as in the rig, with what was found: lens, and pose in the rig's lens space
  bool has_lens = false;  // else as the rig file says
  int group = -1;         // cameras that are joined by shots have the same; -1 without a lens
  bool joined = false;    // to at least one other
  Vec3 position_m{0.0};   // from the middle of its group's cameras, in the rig's lens space
  int shots = 0;          // that show the whole board, those left out not counted
  double rms = 0.0;       // texels, reprojected less seen
  double worst = 0.0;
  int worst_shot = -1;
  double edge_texels = 0.0;  // the median over shots of the width of a square's edge
  // Standard deviations as the residuals have them; the turn and the place are against the group's first.
  double focal_deviation = 0.0;  // share
  double turn_deviation_deg = 0.0;
  double place_deviation_m = 0.0;
};

// Where two views meet: how far apart the same far point may come out in them, expected from the residuals.
struct SeamCalibration {
  int a = 0, b = 0;
  double rms = 0.0;    // texels of b
  double worst = 0.0;  // at the direction where it is largest
};

struct LeftOutShot {
  int shot = 0;
  int camera = 0;    // where it is off most
  double rms = 0.0;  // texels
};

struct RigCalibration {
  std::vector<CameraCalibration> cameras;  // one a view
  std::vector<SeamCalibration> seams;
  std::vector<LeftOutShot> left_out;
  std::vector<std::string> troubles;  // what is poor or missing, and what to do about it
};

inline constexpr int kFewestShots = 6;

// `shots` are their names. Views without sightings keep what the rig has. `model` none: whichever fits
// better.
RigCalibration calibrate_rig(const Rig& rig, const Board& board, std::span<const Sighting> sightings,
                             std::span<const std::string> shots, std::span<const Size> sizes,
                             std::optional<Distortion> model, WorkerPool& pool);

}  // namespace cupola
