// Normal equations over all unknowns, dense: four cameras and a hundred shots are a few hundred of them.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/adjustment.h"

#include <algorithm>
#include <cmath>

#include "pipeline/portable/cholesky.h"

namespace cupola {
namespace {

constexpr std::size_t kLens = 6;  // the first parameter of a camera that is not its pose
constexpr std::size_t kBoardParameters = 6;
constexpr int kMostSteps = 100;

double& lens_parameter(View& view, std::size_t which) {
  switch (which) {
    case 0:
      return view.focal.x;
    case 1:
      return view.focal.y;
    case 2:
      return view.principal.x;
    case 3:
      return view.principal.y;
    default:
      return view.coefficients[which - 4];
  }
}

// Huber's cost of a point that is `square` off, and the weight its square counts with.
double huber_cost(double square, double limit) {
  const double off = std::sqrt(square);
  return off <= limit ? square : limit * (2.0 * off - limit);
}
double huber_weight(double square, double limit) {
  return square <= limit * limit ? 1.0 : limit / std::sqrt(square);
}

}  // namespace

bool camera_slopes(const View& view, const Vec3& d, Vec2& at, std::array<Vec2, kCameraParameters>& slopes) {
  ViewSample sample;
  if (!project(view, d, sample)) return false;
  at = sample.uv;
  // The camera's turn about w moves the point by -w x d, as the camera sees it; its place by -1.
  const Vec3 turn_u = glm::cross(sample.du, d);
  const Vec3 turn_v = glm::cross(sample.dv, d);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<glm::length_t>(i);
    slopes[i] = {turn_u[axis], turn_v[axis]};
    slopes[3 + i] = {-sample.du[axis], -sample.dv[axis]};
  }
  View moved = view;
  for (std::size_t i = 0; i < kCameraParameters - kLens; ++i) {
    constexpr double kStep = 1e-6;
    double& parameter = lens_parameter(moved, i);
    const double here = parameter;
    Vec2 above;
    Vec2 below;
    parameter = here + kStep;
    if (!project(moved, d, above)) return false;
    parameter = here - kStep;
    if (!project(moved, d, below)) return false;
    parameter = here;
    slopes[kLens + i] = (above - below) / (2.0 * kStep);
  }
  return true;
}

Adjustment::Adjustment(std::vector<AdjustedCamera> cameras, std::vector<Pose> boards,
                       std::span<const Sighting> sightings, const Board& board)
    : cameras_(std::move(cameras)),
      boards_(std::move(boards)),
      sightings_(sightings.begin(), sightings.end()),
      corners_(board_corners(board)) {
  const auto next = [&] { return static_cast<int>(unknowns_++); };
  for (AdjustedCamera& camera : cameras_) {
    camera.view.limit = camera.view.distortion == Distortion::kFisheye ? 3.1415 : 1e6;
    std::array<int, kCameraParameters>& places = camera_places_.emplace_back();
    for (std::size_t i = 0; i < kCameraParameters; ++i) {
      const bool fitted = i < kLens ? !camera.held : i < kLens + 4 + static_cast<std::size_t>(camera.bends);
      places[i] = fitted ? next() : -1;
    }
  }
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    board_places_.push_back(static_cast<int>(unknowns_));
    unknowns_ += kBoardParameters;
  }
}

double Adjustment::cost(const std::vector<AdjustedCamera>& cameras, const std::vector<Pose>& boards,
                        std::vector<std::vector<Vec2>>* residuals) const {
  double sum = 0.0;
  if (residuals) residuals->assign(sightings_.size(), {});
  for (std::size_t s = 0; s < sightings_.size(); ++s) {
    const AdjustedCamera& camera = cameras[static_cast<std::size_t>(sightings_[s].camera)];
    const Pose& pose = boards[static_cast<std::size_t>(sightings_[s].shot)];
    for (std::size_t c = 0; c < corners_.size(); ++c) {
      Vec2 at;
      if (!project(camera.view, pose(corners_[c]) - camera.place, at)) return HUGE_VAL;
      const Vec2 off = at - sightings_[s].corners[c];
      sum += huber_cost(glm::dot(off, off), huber_);
      if (residuals) (*residuals)[s].push_back(off);
    }
  }
  return std::isfinite(sum) ? sum : HUGE_VAL;
}

// The lower triangle of J^T W J by rows, and J^T W r. Returns the sum of the weights.
double Adjustment::build(std::vector<double>& normal, std::vector<double>& gradient) const {
  normal.assign(unknowns_ * unknowns_, 0.0);
  gradient.assign(unknowns_, 0.0);
  double weights = 0.0;
  constexpr std::size_t kMost = kCameraParameters + kBoardParameters;
  std::array<int, kMost> places{};
  std::array<Vec2, kMost> slopes{};
  for (const Sighting& sighting : sightings_) {
    const AdjustedCamera& camera = cameras_[static_cast<std::size_t>(sighting.camera)];
    const Pose& pose = boards_[static_cast<std::size_t>(sighting.shot)];
    const auto& own = camera_places_[static_cast<std::size_t>(sighting.camera)];
    for (std::size_t c = 0; c < corners_.size(); ++c) {
      const Vec3 arm = pose.turn * corners_[c];
      Vec2 at;
      std::array<Vec2, kCameraParameters> of_camera{};
      if (!camera_slopes(camera.view, arm + pose.place - camera.place, at, of_camera)) continue;
      std::size_t count = 0;
      for (std::size_t i = 0; i < kCameraParameters; ++i) {
        if (own[i] < 0) continue;
        places[count] = own[i];
        slopes[count++] = of_camera[i];
      }
      const Vec3 du{-of_camera[3].x, -of_camera[4].x, -of_camera[5].x};
      const Vec3 dv{-of_camera[3].y, -of_camera[4].y, -of_camera[5].y};
      const Vec3 turn_u = glm::cross(arm, du);
      const Vec3 turn_v = glm::cross(arm, dv);
      for (int i = 0; i < 6; ++i) {
        const int axis = i % 3;
        places[count] = board_places_[static_cast<std::size_t>(sighting.shot)] + i;
        slopes[count++] = i < 3 ? Vec2{turn_u[axis], turn_v[axis]} : Vec2{du[axis], dv[axis]};
      }
      const Vec2 off = at - sighting.corners[c];
      const double weight = huber_weight(glm::dot(off, off), huber_);
      weights += weight;
      for (std::size_t i = 0; i < count; ++i) {
        const auto row = static_cast<std::size_t>(places[i]);
        gradient[row] += weight * glm::dot(slopes[i], off);
        for (std::size_t j = 0; j <= i; ++j) {
          // A camera's unknowns come before every board's, and both rise.
          normal[row * unknowns_ + static_cast<std::size_t>(places[j])] +=
              weight * glm::dot(slopes[i], slopes[j]);
        }
      }
    }
  }
  return weights;
}

void Adjustment::step(const std::vector<double>& by, std::vector<AdjustedCamera>& cameras,
                      std::vector<Pose>& boards) const {
  const auto three = [&](int place) {
    const auto i = static_cast<std::size_t>(place);
    return Vec3{by[i], by[i + 1], by[i + 2]};
  };
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    AdjustedCamera& camera = cameras[c];
    const auto& places = camera_places_[c];
    if (!camera.held) {
      set_axes(camera.view, turn_about(three(places[0])) * camera_axes(camera.view));
      camera.place += three(places[3]);
    }
    for (std::size_t i = kLens; i < kCameraParameters; ++i) {
      if (places[i] >= 0) lens_parameter(camera.view, i - kLens) += by[static_cast<std::size_t>(places[i])];
    }
  }
  for (std::size_t b = 0; b < boards.size(); ++b) {
    boards[b].turn = turn_about(three(board_places_[b])) * boards[b].turn;
    boards[b].place += three(board_places_[b] + 3);
  }
}

bool Adjustment::descend() {
  double now = cost(cameras_, boards_, nullptr);
  if (!(now < HUGE_VAL)) return false;
  double damping = 1e-3;
  std::vector<double> normal;
  std::vector<double> gradient;
  for (int i = 0; i < kMostSteps; ++i) {
    build(normal, gradient);
    bool better = false;
    double gained = 0.0;
    while (!better && damping < 1e10) {
      std::vector<double> factor = normal;
      for (std::size_t k = 0; k < unknowns_; ++k) factor[k * unknowns_ + k] *= 1.0 + damping;
      std::vector<double> by = gradient;
      for (double& value : by) value = -value;
      if (factorise(factor, unknowns_)) {
        solve(factor, unknowns_, by);
        std::vector<AdjustedCamera> cameras = cameras_;
        std::vector<Pose> boards = boards_;
        step(by, cameras, boards);
        const double then = cost(cameras, boards, nullptr);
        if (then <= now) {
          better = true;
          gained = now - then;
          now = then;
          cameras_ = std::move(cameras);
          boards_ = std::move(boards);
        }
      }
      damping = better ? std::max(1e-12, damping * 0.1) : damping * 10.0;
    }
    if (!better || gained <= 1e-8 * now) break;
  }
  return true;
}

bool Adjustment::fit() {
  // What is usual shows only once it is fitted: first everything counts, within reason.
  for (int round = 0; round < 4; ++round) {
    if (!(cost(cameras_, boards_, &residuals_) < HUGE_VAL)) return false;
    std::vector<double> squares;
    for (const auto& sighting : residuals_)
      for (const Vec2& off : sighting) squares.push_back(glm::dot(off, off));
    const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
    std::nth_element(squares.begin(), middle, squares.end());
    // The median distance of two normal coordinates is 1.177 of their deviation.
    sigma_ = std::max(1e-6, std::sqrt(*middle) / 1.177);
    huber_ = std::max(0.01, 3.0 * sigma_);
    if (round == 3) break;
    if (!descend()) return false;
  }
  find_covariance();
  return true;
}

void Adjustment::find_covariance() {
  std::vector<double> gradient;
  const double weights = build(inverse_, gradient);
  double squares = 0.0;
  for (const auto& sighting : residuals_) {
    for (const Vec2& off : sighting) {
      const double square = glm::dot(off, off);
      squares += square * huber_weight(square, huber_);
    }
  }
  const double freedom = std::max(1.0, 2.0 * weights - static_cast<double>(unknowns_));
  sigma_ = std::sqrt(squares / freedom);
  if (!factorise(inverse_, unknowns_)) {
    inverse_.clear();
    return;
  }
  invert(inverse_, unknowns_);
}

Adjustment::Block Adjustment::covariance(std::size_t a, std::size_t b) const {
  Block block{};
  for (std::size_t i = 0; i < kCameraParameters; ++i) {
    for (std::size_t j = 0; j < kCameraParameters; ++j) {
      const int row = camera_places_[a][i];
      const int column = camera_places_[b][j];
      if (row < 0 || column < 0) continue;
      block[i][j] =
          inverse_.empty()
              ? HUGE_VAL
              : sigma_ * sigma_ *
                    inverse_[static_cast<std::size_t>(row) * unknowns_ + static_cast<std::size_t>(column)];
    }
  }
  return block;
}

}  // namespace cupola
