// One least-squares fit over cameras and boards together: what the reprojection of every corner says of every
// lens, every camera's pose and every board's.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "pipeline/calibrate/board.h"
#include "pipeline/calibrate/pose.h"
#include "pipeline/calibrate/sighting.h"

namespace cupola {

struct AdjustedCamera {
  View view;          // pose and lens
  Vec3 place{0.0};    // metres, in the axes of the view's pose
  bool held = false;  // its pose is given, not fitted
  int bends = 5;      // coefficients that are fitted, of 5 (radial-tangential) or 4 (fisheye)
};

// Parameters of a camera, in this order: turn (radians about the rig's axes) and place, each 3; focal and
// principal (shares of the picture), each 2; coefficients.
inline constexpr std::size_t kCameraParameters = 15;

class Adjustment {
 public:
  // `boards` are rig-from-board, one a shot; sightings name camera and shot by their places in these.
  // Everything is copied.
  Adjustment(std::vector<AdjustedCamera> cameras, std::vector<Pose> boards,
             std::span<const Sighting> sightings, const Board& board);

  // Levenberg and Marquardt's method, with Huber's weights: what is farther off than three times the usual
  // counts by its distance, not by its square. False when some corner cannot be projected at all.
  bool fit();

  const std::vector<AdjustedCamera>& cameras() const { return cameras_; }
  const std::vector<Pose>& boards() const { return boards_; }
  // Reprojected less seen, in texels, by sighting and corner; after fit().
  const std::vector<std::vector<Vec2>>& residuals() const { return residuals_; }
  double sigma() const { return sigma_; }  // texels, a corner's coordinate

  // Covariance of the parameters of cameras `a` and `b`, by rows of a's; 0 for what is held. After fit().
  using Block = std::array<std::array<double, kCameraParameters>, kCameraParameters>;
  Block covariance(std::size_t a, std::size_t b) const;

 private:
  double cost(const std::vector<AdjustedCamera>& cameras, const std::vector<Pose>& boards,
              std::vector<std::vector<Vec2>>* residuals) const;
  double build(std::vector<double>& normal, std::vector<double>& gradient) const;
  void step(const std::vector<double>& by, std::vector<AdjustedCamera>& cameras,
            std::vector<Pose>& boards) const;
  bool descend();
  void find_covariance();

  std::vector<AdjustedCamera> cameras_;
  std::vector<Pose> boards_;
  std::vector<Sighting> sightings_;
  std::vector<Vec3> corners_;
  std::vector<std::array<int, kCameraParameters>> camera_places_;  // in the unknowns; -1: held
  std::vector<int> board_places_;
  std::size_t unknowns_ = 0;
  double huber_ = 1e9;  // texels
  double sigma_ = 0.0;
  std::vector<std::vector<Vec2>> residuals_;
  std::vector<double> inverse_;  // unknowns x unknowns
};

// What a view's projection of direction `d` (any length) gains a unit of each parameter of its camera, whose
// distance scales the share of its place: `d` runs from the camera to the point. False where the model does
// not reach.
bool camera_slopes(const View& view, const Vec3& d, Vec2& at, std::array<Vec2, kCameraParameters>& slopes);

}  // namespace cupola
