// Lenses one by one, poses from shots in common, then everything together.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/rig_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/calibrate/adjustment.h"
#include "pipeline/calibrate/camera_fit.h"
#include "pipeline/calibrate/coverage.h"
#include "pipeline/calibrate/seam_error.h"
#include "pipeline/optics/calibration.h"
#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

constexpr int kFewestCommonShots = 3;
constexpr double kPoorRms = 1.0;      // texels
constexpr double kPoorFocal = 0.005;  // share
constexpr double kPoorSeam = 1.0;     // texels

struct Known {  // of one camera in one shot
  const Sighting* sighting;
  Pose board;  // in the camera's axes
};

// A camera from another, as the shots that both see have it: the one that the others agree with most.
std::optional<Pose> between(const std::map<int, Known>& a, const std::map<int, Known>& b, int& common) {
  std::vector<Pose> all;  // a from b
  for (const auto& [shot, known] : a) {
    const auto other = b.find(shot);
    if (other != b.end()) all.push_back(known.board * inverse(other->second.board));
  }
  common = static_cast<int>(all.size());
  if (all.empty()) return std::nullopt;
  double best = HUGE_VAL;
  Pose chosen;
  for (const Pose& pose : all) {
    double sum = 0.0;
    for (const Pose& other : all)
      sum += angle_between(pose.turn, other.turn) + glm::length(pose.place - other.place);
    if (sum < best) {
      best = sum;
      chosen = pose;
    }
  }
  return chosen;
}

class RigFit {
 public:
  RigFit(const Rig& rig, const Board& board, std::span<const Sighting> sightings,
         std::span<const std::string> shots, std::span<const Size> sizes, std::optional<Distortion> model,
         WorkerPool& pool);
  RigCalibration result() &&;

 private:
  void fit_lenses(std::span<const Sighting> sightings, std::span<const Size> sizes,
                  std::optional<Distortion> model, WorkerPool& pool);
  void say_what_is_missing(std::size_t camera, std::span<const Sighting* const> all, Size size);
  void join();
  Adjustment fit_together();
  void take(const Adjustment& adjustment);
  void judge(const Adjustment& adjustment);
  std::vector<Pose> place_boards(const std::vector<AdjustedCamera>& cameras) const;

  const Rig& rig_;
  const Board& board_;
  std::span<const std::string> shots_;
  std::vector<std::map<int, Known>> known_;  // by camera and shot
  std::vector<int> bends_;
  std::vector<Vec3> places_;
  std::vector<Sighting> used_;
  std::vector<int> anchors_;  // of each group
  RigCalibration result_;
};

RigFit::RigFit(const Rig& rig, const Board& board, std::span<const Sighting> sightings,
               std::span<const std::string> shots, std::span<const Size> sizes,
               std::optional<Distortion> model, WorkerPool& pool)
    : rig_(rig), board_(board), shots_(shots) {
  result_.cameras.resize(rig.views.size());
  known_.resize(rig.views.size());
  bends_.resize(rig.views.size());
  places_.resize(rig.views.size(), Vec3{0.0});
  for (std::size_t c = 0; c < rig.views.size(); ++c) {
    result_.cameras[c].view = rig.views[c];
    result_.cameras[c].view.shift = Vec3{0.0};  // directions are the camera's own here
  }
  fit_lenses(sightings, sizes, model, pool);
  join();
}

void RigFit::say_what_is_missing(std::size_t camera, std::span<const Sighting* const> all, Size size) {
  const std::string& name = rig_.views[camera].name;
  for (const std::string& part : parts_without_board(all, size))
    result_.troubles.push_back(
        fmt::format("camera {}: no board in {} of the picture: take shots there", name, part));
}

void RigFit::fit_lenses(std::span<const Sighting> sightings, std::span<const Size> sizes,
                        std::optional<Distortion> model, WorkerPool& pool) {
  const std::size_t count = rig_.views.size();
  std::vector<std::vector<const Sighting*>> all(count);
  for (const Sighting& sighting : sightings)
    all[static_cast<std::size_t>(sighting.camera)].push_back(&sighting);
  std::vector<std::optional<CameraFit>> fits(count);
  pool.run(static_cast<int>(count), [&](int camera) {
    const auto c = static_cast<std::size_t>(camera);
    if (static_cast<int>(all[c].size()) >= kFewestShots)
      fits[c] = fit_camera(all[c], board_, sizes[c], model);
  });
  for (std::size_t c = 0; c < count; ++c) {
    CameraCalibration& camera = result_.cameras[c];
    camera.shots = static_cast<int>(all[c].size());
    if (sizes[c] == Size{}) {
      result_.troubles.push_back(fmt::format(
          "camera {}: no pictures; its lens and pose stay as the rig file has them", camera.view.name));
      continue;
    }
    if (camera.shots < kFewestShots) {
      result_.troubles.push_back(fmt::format(
          "camera {}: {} shots show the whole board: expected {} or more, 15 are good; its lens and "
          "pose stay as the rig file has them",
          camera.view.name, camera.shots, kFewestShots));
      continue;
    }
    say_what_is_missing(c, all[c], sizes[c]);
    if (!fits[c]) {
      result_.troubles.push_back(
          fmt::format("camera {}: no lens fits its {} shots: take some with the board tilted and in the "
                      "picture's corners; its lens and pose stay as the rig file has them",
                      camera.view.name, camera.shots));
      continue;
    }
    const CameraFit& fit = *fits[c];
    camera.has_lens = true;
    camera.view.size = sizes[c];
    camera.view.focal = fit.view.focal;
    camera.view.principal = fit.view.principal;
    camera.view.distortion = fit.view.distortion;
    camera.view.coefficients = fit.view.coefficients;
    bends_[c] = fit.bends;
    for (std::size_t i = 0; i < fit.sightings.size(); ++i)
      known_[c][fit.sightings[i]->shot] = {fit.sightings[i], fit.boards[i]};
    for (std::size_t i = 0; i < fit.left_out.size(); ++i)
      result_.left_out.push_back({fit.left_out[i]->shot, static_cast<int>(c), fit.left_out_rms[i]});
  }
}

// Every camera's pose from its group's first one, over the pairs with most shots in common.
void RigFit::join() {
  const std::size_t count = rig_.views.size();
  for (std::size_t first = 0; first < count; ++first) {
    if (!result_.cameras[first].has_lens || result_.cameras[first].group >= 0) continue;
    const int group = static_cast<int>(anchors_.size());
    anchors_.push_back(static_cast<int>(first));
    result_.cameras[first].group = group;
    for (;;) {
      int most = 0;
      std::size_t from = 0;
      std::size_t to = 0;
      Pose pose;
      for (std::size_t a = 0; a < count; ++a) {
        if (result_.cameras[a].group != group) continue;
        for (std::size_t b = 0; b < count; ++b) {
          if (!result_.cameras[b].has_lens || result_.cameras[b].group >= 0) continue;
          int common = 0;
          const std::optional<Pose> relative = between(known_[a], known_[b], common);
          if (common <= most) continue;
          most = common;
          from = a;
          to = b;
          pose = *relative;
        }
      }
      if (most == 0) break;
      const Pose there = Pose{camera_axes(result_.cameras[from].view), places_[from]} * pose;
      set_axes(result_.cameras[to].view, there.turn);
      places_[to] = there.place;
      result_.cameras[to].group = group;
      result_.cameras[to].joined = result_.cameras[first].joined = true;
      if (most < kFewestCommonShots) {
        result_.troubles.push_back(
            fmt::format("cameras {} and {}: {} in common: expected {} or more with the whole board in both",
                        rig_.views[from].name, rig_.views[to].name, most == 1 ? "1 shot" : "2 shots",
                        kFewestCommonShots));
      }
    }
  }
}

std::vector<Pose> RigFit::place_boards(const std::vector<AdjustedCamera>& cameras) const {
  std::vector<Pose> boards(shots_.size());
  for (std::size_t c = cameras.size(); c-- > 0;) {
    const Pose camera{camera_axes(cameras[c].view), cameras[c].place};
    for (const auto& [shot, known] : known_[c]) boards[static_cast<std::size_t>(shot)] = camera * known.board;
  }
  return boards;
}

// Fits, leaves the worst shot out, fits again, until all agree.
Adjustment RigFit::fit_together() {
  std::vector<AdjustedCamera> cameras;
  for (std::size_t c = 0; c < rig_.views.size(); ++c) {
    const CameraCalibration& camera = result_.cameras[c];
    AdjustedCamera& adjusted = cameras.emplace_back();
    adjusted.view = camera.view;
    adjusted.place = places_[c];
    adjusted.bends = bends_[c];
    adjusted.held =
        !camera.has_lens || anchors_[static_cast<std::size_t>(camera.group)] == static_cast<int>(c);
  }
  std::vector<Pose> boards = place_boards(cameras);
  for (;;) {
    // Only what is seen is unknown: cameras and shots by their places among those.
    std::vector<AdjustedCamera> seeing;
    std::vector<int> camera_place(cameras.size(), -1);
    std::map<int, int> shot_place;
    std::vector<Pose> seen;
    used_.clear();
    std::vector<Sighting> moved;
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      if (known_[c].empty()) continue;
      camera_place[c] = static_cast<int>(seeing.size());
      seeing.push_back(cameras[c]);
      for (const auto& [shot, known] : known_[c]) {
        if (shot_place.try_emplace(shot, static_cast<int>(seen.size())).second)
          seen.push_back(boards[static_cast<std::size_t>(shot)]);
        used_.push_back(*known.sighting);
        moved.push_back(*known.sighting);
        moved.back().camera = camera_place[c];
        moved.back().shot = shot_place[shot];
      }
    }
    Adjustment adjustment(seeing, seen, moved, board_);
    const bool fits = adjustment.fit();
    for (std::size_t c = 0; fits && c < cameras.size(); ++c) {
      if (camera_place[c] >= 0) cameras[c] = adjustment.cameras()[static_cast<std::size_t>(camera_place[c])];
    }
    for (const auto& [shot, place] : shot_place) {
      if (fits) boards[static_cast<std::size_t>(shot)] = adjustment.boards()[static_cast<std::size_t>(place)];
    }
    const std::optional<std::size_t> worst = fits ? stranger(adjustment) : std::nullopt;
    if (!worst) {
      for (std::size_t c = 0; c < cameras.size(); ++c) {
        if (!result_.cameras[c].has_lens) continue;
        result_.cameras[c].view = cameras[c].view;
        places_[c] = cameras[c].place;
      }
      return adjustment;
    }
    const Sighting& bad = used_[*worst];
    result_.left_out.push_back({bad.shot, bad.camera, rms_of(adjustment.residuals()[*worst])});
    for (std::map<int, Known>& known : known_) known.erase(bad.shot);
  }
}

void RigFit::take(const Adjustment& adjustment) {
  std::vector<std::vector<double>> edges(rig_.views.size());
  std::vector<double> squares(rig_.views.size(), 0.0);
  std::vector<double> corners(rig_.views.size(), 0.0);
  for (CameraCalibration& camera : result_.cameras) {
    if (camera.has_lens) camera.shots = 0;
  }
  for (std::size_t s = 0; s < used_.size(); ++s) {
    const auto c = static_cast<std::size_t>(used_[s].camera);
    CameraCalibration& camera = result_.cameras[c];
    ++camera.shots;
    edges[c].push_back(used_[s].edge_texels);
    for (const Vec2& off : adjustment.residuals()[s]) {
      squares[c] += glm::dot(off, off);
      corners[c] += 1.0;
      if (glm::length(off) <= camera.worst) continue;
      camera.worst = glm::length(off);
      camera.worst_shot = used_[s].shot;
    }
  }
  std::vector<Vec3> middles(anchors_.size(), Vec3{0.0});
  std::vector<double> counts(anchors_.size(), 0.0);
  for (std::size_t c = 0; c < rig_.views.size(); ++c) {
    if (!result_.cameras[c].has_lens) continue;
    middles[static_cast<std::size_t>(result_.cameras[c].group)] += places_[c];
    counts[static_cast<std::size_t>(result_.cameras[c].group)] += 1.0;
  }
  std::size_t place = 0;  // among the cameras of the fit
  for (std::size_t c = 0; c < rig_.views.size(); ++c) {
    CameraCalibration& camera = result_.cameras[c];
    if (!camera.has_lens || known_[c].empty()) continue;
    camera.rms = std::sqrt(squares[c] / std::max(1.0, corners[c]));
    if (!edges[c].empty()) {
      const auto middle = edges[c].begin() + static_cast<std::ptrdiff_t>(edges[c].size() / 2);
      std::nth_element(edges[c].begin(), middle, edges[c].end());
      camera.edge_texels = *middle;
    }
    const auto group = static_cast<std::size_t>(camera.group);
    camera.position_m = places_[c] - middles[group] / counts[group];
    const Adjustment::Block spread = adjustment.covariance(place, place);
    ++place;
    const auto sum = [&](std::size_t first) {
      return std::sqrt(spread[first][first] + spread[first + 1][first + 1] + spread[first + 2][first + 2]);
    };
    camera.turn_deviation_deg = sum(0) * 180.0 / portable::kPi;
    camera.place_deviation_m = sum(3);
    camera.focal_deviation = std::sqrt(spread[6][6]) / camera.view.focal.x;
  }
}

void RigFit::judge(const Adjustment& adjustment) {
  std::vector<std::size_t> places(rig_.views.size());
  std::vector<View> views;
  std::size_t place = 0;
  for (std::size_t c = 0; c < rig_.views.size(); ++c) {
    CameraCalibration& camera = result_.cameras[c];
    if (!camera.has_lens || known_[c].empty()) {
      views.emplace_back();  // covers nothing
      continue;
    }
    places[c] = place++;
    const std::string wrong = limit_distortion(camera.view);
    if (!wrong.empty()) result_.troubles.push_back(fmt::format("camera {}: {}", camera.view.name, wrong));
    if (camera.rms > kPoorRms)
      result_.troubles.push_back(
          fmt::format("camera {}: off by {:.2f} texels: expected {:g} at most: is the board flat, --board "
                      "and --square-mm "
                      "right, the picture sharp?",
                      camera.view.name, camera.rms, kPoorRms));
    if (!(camera.focal_deviation <= kPoorFocal))
      result_.troubles.push_back(fmt::format(
          "camera {}: its focal length is known to {:.2f} % only: take shots with the board tilted "
          "by 30 degrees and more",
          camera.view.name, 100.0 * camera.focal_deviation));
    if (!camera.joined && rig_.views.size() > 1)
      result_.troubles.push_back(fmt::format(
          "camera {}: no shot shows the whole board to it and to another camera; its pose stays as "
          "the rig file has it",
          camera.view.name));
    views.push_back(camera.view);
  }
  for (std::size_t group = 1; group < anchors_.size(); ++group) {
    const CameraCalibration& first = result_.cameras[static_cast<std::size_t>(anchors_[group])];
    if (!first.joined) continue;
    result_.troubles.push_back(fmt::format(
        "camera {}: no shot joins it and its neighbours to {}; its own pose stays as the rig file has it",
        first.view.name, result_.cameras[static_cast<std::size_t>(anchors_[0])].view.name));
  }
  for (SeamCalibration seam : expected_seam_errors(views, [&](std::size_t a, std::size_t b) {
         return adjustment.covariance(places[a], places[b]);
       })) {
    const auto a = static_cast<std::size_t>(seam.a);
    const auto b = static_cast<std::size_t>(seam.b);
    if (result_.cameras[a].group != result_.cameras[b].group) continue;
    if (seam.rms > kPoorSeam)
      result_.troubles.push_back(
          fmt::format("views {} and {}: a seam of {:.2f} texels is expected: take more shots that both see",
                      views[a].name, views[b].name, seam.rms));
    result_.seams.push_back(seam);
  }
}

RigCalibration RigFit::result() && {
  if (!anchors_.empty()) {
    const Adjustment adjustment = fit_together();
    take(adjustment);
    judge(adjustment);
  }
  return std::move(result_);
}

}  // namespace

RigCalibration calibrate_rig(const Rig& rig, const Board& board, std::span<const Sighting> sightings,
                             std::span<const std::string> shots, std::span<const Size> sizes,
                             std::optional<Distortion> model, WorkerPool& pool) {
  return RigFit(rig, board, sightings, shots, sizes, model, pool).result();
}

}  // namespace cupola
