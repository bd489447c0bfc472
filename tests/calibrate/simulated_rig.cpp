// The cameras' errors, the shots' places, and rays to a chessboard.
// SPDX-License-Identifier: MIT
#include "tests/calibrate/simulated_rig.h"

#include <cmath>

#include "pipeline/optics/calibration.h"
#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

constexpr double kEdge = 8.0;  // texels

// A board at `middle`, seen from `eye`, tilted by two angles and turned about its middle.
Pose board_at(const Vec3& middle, const Vec3& eye, double tilt_x, double tilt_y, double roll) {
  const Vec3 away = glm::normalize(middle - eye);
  const Vec3 right = glm::normalize(glm::cross(away, std::abs(away.y) < 0.9 ? Vec3{0, 1, 0} : Vec3{0, 0, 1}));
  const Mat3 facing{right, glm::cross(away, right), away};
  return {facing * turn_about({0, 0, roll}) * turn_about({tilt_x, 0, 0}) * turn_about({0, tilt_y, 0}),
          middle};
}

bool in_all(const std::vector<SimulatedCamera>& cameras, const SimulatedShot& shot, const Board& board) {
  return std::all_of(shot.cameras.begin(), shot.cameras.end(), [&](int camera) {
    return exact_sighting(cameras[static_cast<std::size_t>(camera)], board, shot.board).has_value();
  });
}

}  // namespace

double SimulatedNoise::even() {
  state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
  return (static_cast<double>(state_ >> 33U) + 0.5) / static_cast<double>(1ULL << 31U);
}

double SimulatedNoise::next() {
  const double radius = std::sqrt(-2.0 * std::log(even()));
  return radius * std::cos(2.0 * portable::kPi * even());
}

std::vector<View> nominal_views(Size size) {
  std::vector<View> views;
  for (const char* name : {"front", "left", "right", "top"}) {
    View& view = views.emplace_back();
    named_pose(name, view);
    view.name = name;
    view.size = size;
    view.focal = Vec2{0.5 / std::tan(portable::radians(60.0))};
  }
  return views;
}

std::vector<SimulatedCamera> simulated_cameras(Size size) {
  std::vector<SimulatedCamera> cameras;
  SimulatedNoise noise(7);
  for (const View& nominal : nominal_views(size)) {
    SimulatedCamera& camera = cameras.emplace_back();
    camera.view = nominal;
    View& view = camera.view;
    view.focal *= 1.0 + 0.02 * noise.next();
    view.focal.y *= 1.0 + 0.001 * noise.next();
    view.principal += Vec2{0.008 * noise.next(), 0.008 * noise.next()};
    view.distortion = Distortion::kRadialTangential;
    view.coefficients = {-0.02 + 0.004 * noise.next(), 0.002, 0.0005 * noise.next(), 0.0005 * noise.next(),
                         0.0};
    const bool first = cameras.size() == 1;
    const Vec3 turn{noise.next(), noise.next(), noise.next()};
    if (!first) set_axes(view, turn_about(0.02 * turn) * camera_axes(view));
    camera.place = 0.06 * view.forward + 0.005 * Vec3{noise.next(), noise.next(), noise.next()};
    limit_distortion(view);
  }
  return cameras;
}

std::optional<Sighting> exact_sighting(const SimulatedCamera& camera, const Board& board, const Pose& pose) {
  Sighting sighting;
  for (const Vec3& corner : board_corners(board)) {
    Vec2 at;
    if (!project(camera.view, pose(corner) - camera.place, at)) return std::nullopt;
    const Size size = camera.view.size;
    if (!(at.x > kEdge && at.y > kEdge && at.x < size.width - kEdge && at.y < size.height - kEdge))
      return std::nullopt;
    sighting.corners.push_back(at);
  }
  return sighting;
}

std::vector<SimulatedShot> simulated_shots(const std::vector<SimulatedCamera>& cameras, const Board& board,
                                           int own, int common) {
  std::vector<SimulatedShot> shots;
  SimulatedNoise noise(3);
  const double board_m = board.columns * board.square_m;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const View& view = cameras[c].view;
    for (int i = 0; i < own; ++i) {
      // Over the picture in a grid of three by three; nearer the middle until the whole board is in it.
      const Vec2 aim{static_cast<double>(i % 3 - 1), static_cast<double>(i / 3 % 3 - 1)};
      SimulatedShot shot{{}, {static_cast<int>(c)}};
      const double distance = board_m * (i < 9 ? 1.5 : 1.1);
      const double tilt_x = 0.5 * noise.next();
      const double tilt_y = 0.5 * noise.next();
      const double roll = 0.5 * noise.next();
      for (double reach = 0.46; reach > 0.0; reach -= 0.02) {
        const Vec2 at{(0.5 + reach * aim.x) * view.size.width, (0.5 + reach * aim.y) * view.size.height};
        const Vec3 middle = cameras[c].place + distance * direction_at(view, at);
        shot.board = board_at(middle, cameras[c].place, tilt_x, tilt_y, roll);
        if (in_all(cameras, shot, board)) break;
      }
      if (in_all(cameras, shot, board)) shots.push_back(shot);
    }
  }
  for (std::size_t a = 0; a < cameras.size(); ++a) {
    for (std::size_t b = a + 1; b < cameras.size(); ++b) {
      const Vec3 between = cameras[a].view.forward + cameras[b].view.forward;
      if (glm::length(between) < 1.0) continue;  // they look away from each other
      const Vec3 along = glm::cross(cameras[a].view.forward, cameras[b].view.forward);
      int taken = 0;
      for (int i = 0; taken < common && i < 20 * common; ++i) {
        const double beside = common > 1 ? 0.6 * (2.0 * taken / (common - 1) - 1.0) : 0.0;
        const Vec3 d =
            glm::normalize(glm::normalize(between) + beside * along + 0.03 * noise.next() * Vec3{1, 1, 1});
        SimulatedShot shot{{}, {static_cast<int>(a), static_cast<int>(b)}};
        shot.board =
            board_at(board_m * 3.5 * d, {}, 0.3 * noise.next(), 0.3 * noise.next(), 1.5 * noise.next());
        if (!in_all(cameras, shot, board)) continue;
        shots.push_back(shot);
        ++taken;
      }
    }
  }
  return shots;
}

std::vector<Sighting> noisy_sightings(const std::vector<SimulatedCamera>& cameras,
                                      const std::vector<SimulatedShot>& shots, const Board& board,
                                      double noise) {
  std::vector<Sighting> sightings;
  SimulatedNoise normal(11);
  for (std::size_t s = 0; s < shots.size(); ++s) {
    for (const int camera : shots[s].cameras) {
      std::optional<Sighting> sighting =
          exact_sighting(cameras[static_cast<std::size_t>(camera)], board, shots[s].board);
      if (!sighting) continue;
      sighting->camera = camera;
      sighting->shot = static_cast<int>(s);
      for (Vec2& at : sighting->corners) at += noise * Vec2{normal.next(), normal.next()};
      sightings.push_back(*sighting);
    }
  }
  return sightings;
}

Photographer::Photographer(const SimulatedCamera& camera) : camera_(camera) {
  const Size size = camera.view.size;
  rays_.reserve(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height) * kRays * kRays);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      for (int i = 0; i < kRays * kRays; ++i) {
        rays_.push_back(
            direction_at(camera.view, {x + (i % kRays + 0.5) / kRays, y + (i / kRays + 0.5) / kRays}));
      }
    }
  }
}

ImageBuffer Photographer::take(const Board& board, const Pose& pose, double noise, std::uint32_t seed) const {
  const Pose seen = inverse(pose);
  const Vec3 eye = seen(camera_.place);
  const double half_width = (board.columns + 1) / 2.0;  // squares
  const double half_height = (board.rows + 1) / 2.0;
  ImageBuffer picture = take([&](const Vec3& ray) {
    const Vec3 d = seen.turn * ray;
    if (eye.z < 0.0 && d.z > 1e-9) {
      const Vec3 on = (eye - d * (eye.z / d.z)) / board.square_m;
      if (std::abs(on.x) < half_width && std::abs(on.y) < half_height) {
        const int square = static_cast<int>(on.x + half_width) + static_cast<int>(on.y + half_height);
        return Vec3(square % 2 == 0 ? 30.0 : 220.0);
      }
      if (std::abs(on.x) < half_width + 1.0 && std::abs(on.y) < half_height + 1.0) return Vec3(220.0);
    }
    return Vec3(110.0 + 40.0 * std::sin(9.0 * ray.x) * std::cos(7.0 * ray.y + 2.0 * ray.z));
  });
  SimulatedNoise normal(seed);
  const MutableImage pixels = picture.pixels();
  for (int y = 0; y < pixels.size.height; ++y) {
    auto* row = pixels.samples<std::uint8_t>(0, y);
    for (int x = 0; x < pixels.size.width; ++x) {
      const double value = std::clamp(row[3 * x] + noise * normal.next() + 0.5, 0.0, 255.0);
      for (int c = 0; c < 3; ++c) row[3 * x + c] = static_cast<std::uint8_t>(value);
    }
  }
  return picture;
}

}  // namespace cupola
