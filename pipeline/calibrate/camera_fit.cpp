// OpenCV's guess, then the fit of docs/calibration.md with one camera in it.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/camera_fit.h"

#include <algorithm>
#include <cmath>

#include "pipeline/calibrate/opencv.h"
#include "pipeline/optics/calibration.h"

namespace cupola {
namespace {

constexpr std::size_t kFewestSightings = 3;
constexpr double kFurthest = 4.0;  // times the median
constexpr double kLeastOff = 0.4;  // texels

// Fits, leaves the worst out, fits again, until all agree.
bool fit_those_that_agree(const Board& board, CameraFit& fit) {
  for (;;) {
    AdjustedCamera camera;
    camera.view = fit.view;
    set_axes(camera.view, Mat3{1.0});
    camera.held = true;
    camera.bends = fit.bends;
    std::vector<Sighting> sightings;
    for (const Sighting* sighting : fit.sightings) {
      sightings.push_back(*sighting);
      sightings.back().camera = 0;
      sightings.back().shot = static_cast<int>(sightings.size()) - 1;
    }
    Adjustment adjustment({camera}, fit.boards, sightings, board);
    if (!adjustment.fit()) return false;
    fit.view = adjustment.cameras()[0].view;
    fit.boards = adjustment.boards();
    double squares = 0.0;
    for (const auto& residuals : adjustment.residuals()) squares += rms_of(residuals) * rms_of(residuals);
    fit.rms = std::sqrt(squares / static_cast<double>(sightings.size()));
    const std::optional<std::size_t> worst = stranger(adjustment);
    if (!worst || fit.sightings.size() <= kFewestSightings) return true;
    const auto at = static_cast<std::ptrdiff_t>(*worst);
    fit.left_out.push_back(fit.sightings[*worst]);
    fit.left_out_rms.push_back(rms_of(adjustment.residuals()[*worst]));
    fit.sightings.erase(fit.sightings.begin() + at);
    fit.boards.erase(fit.boards.begin() + at);
  }
}

std::optional<CameraFit> fit_model(std::span<const Sighting* const> sightings, const Board& board, Size size,
                                   Distortion model) {
  const std::optional<CameraGuess> guess = guess_camera(sightings, board, size, model);
  if (!guess) return std::nullopt;
  // As many coefficients as keep the picture whole: the last one rules where the board was not.
  const bool fisheye = model == Distortion::kFisheye;
  for (const int bends : fisheye ? std::array{4, 2} : std::array{5, 4}) {
    CameraFit fit;
    fit.view = guess->view;
    fit.bends = bends;
    std::fill(fit.view.coefficients.begin() + bends, fit.view.coefficients.end(), 0.0);
    fit.sightings.assign(sightings.begin(), sightings.end());
    fit.boards = guess->boards;
    if (!fit_those_that_agree(board, fit)) continue;
    if (limit_distortion(fit.view).empty()) return fit;
  }
  return std::nullopt;
}

}  // namespace

double rms_of(const std::vector<Vec2>& residuals) {
  double squares = 0.0;
  for (const Vec2& off : residuals) squares += glm::dot(off, off);
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, residuals.size())));
}

std::optional<std::size_t> stranger(const Adjustment& adjustment) {
  std::vector<double> all;
  for (const auto& residuals : adjustment.residuals()) all.push_back(rms_of(residuals));
  const auto worst = std::max_element(all.begin(), all.end());
  const auto which = static_cast<std::size_t>(worst - all.begin());
  const double most = *worst;
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  if (most <= std::max(kLeastOff, kFurthest * *middle)) return std::nullopt;
  return which;
}

std::optional<CameraFit> fit_camera(std::span<const Sighting* const> sightings, const Board& board, Size size,
                                    std::optional<Distortion> model) {
  if (sightings.size() < kFewestSightings) return std::nullopt;
  if (model) return fit_model(sightings, board, size, *model);
  std::optional<CameraFit> radial = fit_model(sightings, board, size, Distortion::kRadialTangential);
  std::optional<CameraFit> fisheye = fit_model(sightings, board, size, Distortion::kFisheye);
  if (!radial) return fisheye;
  if (!fisheye) return radial;
  // More sightings kept first: a lens that fits nothing leaves everything out.
  if (radial->sightings.size() != fisheye->sightings.size())
    return radial->sightings.size() > fisheye->sightings.size() ? radial : fisheye;
  return fisheye->rms < 0.95 * radial->rms ? fisheye : radial;
}

}  // namespace cupola
