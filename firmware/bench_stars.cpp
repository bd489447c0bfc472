// Stars by the texel, energies by the cell of texels that a pixel looks at.
// SPDX-License-Identifier: MIT
#include "firmware/bench_stars.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>

#include "firmware/peer.h"
#include "pipeline/frame/srgb_curve.h"

namespace cupola {
namespace {

constexpr int kCell = 16;  // texels
constexpr int kSteps = 10;
constexpr double kStep = 0.1;  // pixels

struct Star {
  int x, y;  // texel
};

// Somewhere about the middle of its cell, so that stars have all phases.
Star star_of(int cell_x, int cell_y) {
  const unsigned hash = static_cast<unsigned>(cell_x * 73 + cell_y * 179 + 11) * 2654435761U;
  return {cell_x * kCell + 6 + static_cast<int>(hash >> 28 & 3),
          cell_y * kCell + 6 + static_cast<int>(hash >> 24 & 3)};
}

// Shares of the mean. The straight part is no flicker: a texel gets larger or smaller on its way.
std::array<double, kSteps> without_trend(const std::array<double, kSteps>& energy) {
  double mean = 0.0;
  double slope = 0.0;
  double squares = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double at = i - (kSteps - 1) / 2.0;
    mean += energy[i] / kSteps;
    slope += at * energy[i];
    squares += at * at;
  }
  std::array<double, kSteps> rest;
  for (int i = 0; i < kSteps; ++i) {
    rest[i] = (energy[i] - slope / squares * (i - (kSteps - 1) / 2.0)) / mean - 1.0;
  }
  return rest;
}

// What stars add, step by step. Stars whose cell touches the edge of the image or of a face are left out.
class Energies {
 public:
  explicit Energies(const Rig& rig) : across_(rig.views[0].size.width / kCell) {
    energy_.resize(rig.views.size() * static_cast<std::size_t>(across_ * across_));
    whole_.assign(energy_.size(), true);
    seen_.assign(energy_.size(), false);
  }

  // `value`: of a pixel, 0 to 1. The rig's frame may have moved since the last step.
  void add_step(const Rig& rig, int step, double ground, const std::function<double(int x, int y)>& value) {
    for (int y = 0; y < rig.frame.size.height; ++y) {
      for (int x = 0; x < rig.frame.size.width; ++x) {
        DirectionAndSlope looking;
        Vec2 uv;
        if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking)) continue;
        const int view = owner(rig.views, looking.direction);
        if (view < 0 || !project(rig.views[static_cast<std::size_t>(view)], looking.direction, uv)) continue;
        const int cell_x = static_cast<int>(uv.x) / kCell;
        const int cell_y = static_cast<int>(uv.y) / kCell;
        if (cell_x < 1 || cell_y < 1 || cell_x >= across_ - 1 || cell_y >= across_ - 1) continue;
        const auto at = static_cast<std::size_t>((view * across_ + cell_y) * across_ + cell_x);
        energy_[at][static_cast<std::size_t>(step)] += value(x, y) - ground;
        seen_[at] = true;
        if (at_edge(rig, x, y)) whole_[at] = false;
      }
    }
  }

  void summarise(StarRow& row) const {
    double sum = 0.0;
    int stars = 0;
    int never_lit = 0;
    for (std::size_t i = 0; i < energy_.size(); ++i) {
      if (!whole_[i] || !seen_[i]) continue;
      if (std::ranges::none_of(energy_[i], [](double energy) { return energy > 0.0; })) {
        ++never_lit;
        continue;
      }
      const std::array<double, kSteps> flicker = without_trend(energy_[i]);
      double squares = 0.0;
      for (const double change : flicker) squares += change * change / kSteps;
      const auto [least, most] = std::minmax_element(flicker.begin(), flicker.end());
      sum += std::sqrt(squares);
      row.worst_swing = std::max(row.worst_swing, *most - *least);
      ++stars;
    }
    row.mean_variation = stars > 0 ? sum / stars : 0.0;
    row.never_lit = never_lit;
  }

 private:
  static bool at_edge(const Rig& rig, int x, int y) {
    if (x == 0 || y == 0 || x + 1 == rig.frame.size.width || y + 1 == rig.frame.size.height) return true;
    DirectionAndSlope ignored;
    return !ray(rig.frame, {x - 0.5, y + 0.5}, ignored) || !ray(rig.frame, {x + 1.5, y + 0.5}, ignored) ||
           !ray(rig.frame, {x + 0.5, y - 0.5}, ignored) || !ray(rig.frame, {x + 0.5, y + 1.5}, ignored);
  }

  int across_;
  std::vector<std::array<double, kSteps>> energy_;
  std::vector<bool> whole_, seen_;
};

std::vector<ImageBuffer> star_faces(const Rig& rig, double ground, PixelFormat format) {
  std::vector<ImageBuffer> faces;
  for (const View& view : rig.views) {
    faces.emplace_back(format, view.size);
    const auto fill = [&]<class Sample>(Sample most) {
      for (int channel = 0; channel < 3; ++channel) {
        for (int y = 0; y < view.size.height; ++y) {
          std::fill_n(faces.back().pixels().samples<Sample>(channel, y), view.size.width,
                      static_cast<Sample>(std::lround(ground * most)));
        }
        for (int y = 0; y < view.size.height / kCell; ++y) {
          for (int x = 0; x < view.size.width / kCell; ++x) {
            const Star star = star_of(x, y);
            faces.back().pixels().samples<Sample>(channel, star.y)[star.x] = most;
          }
        }
      }
    };
    if (format == PixelFormat::kRgbPlanar16) {
      fill(std::uint16_t{65535});
    } else {
      fill(std::uint8_t{255});
    }
  }
  return faces;
}

std::vector<Image> images_of(const std::vector<ImageBuffer>& buffers) {
  std::vector<Image> images;
  for (const ImageBuffer& buffer : buffers) images.push_back(buffer.pixels());
  return images;
}

Rig moved(Rig rig, int step) {
  rig.frame.center += Vec2{0.8, 0.6} * (step * kStep);
  return rig;
}

StarRow peer_row(const Rig& rig, PeerFilter filter, int ground, WorkerPool& pool) {
  const std::vector<ImageBuffer> faces = star_faces(rig, ground / 100.0, PixelFormat::kRgbPlanar8);
  const std::vector<Image> images = images_of(faces);
  StarRow row{"", ground, 0.0, 0.0, 0};
  Energies energies(rig);
  for (int step = 0; step < kSteps; ++step) {
    const Rig at = moved(rig, step);
    const std::unique_ptr<Peer> peer = make_peer(at, images, filter, pool);
    if (!peer) return row;
    peer->warp();
    row.contender = peer->name();
    const Image frame = peer->frame();
    energies.add_step(at, step, std::round(ground / 100.0 * 255.0) / 255.0,
                      [&](int x, int y) { return frame.samples<std::uint8_t>(0, y)[3 * x] / 255.0; });
  }
  energies.summarise(row);
  return row;
}

}  // namespace

std::vector<Contender> star_contenders() {
  const auto gaussian = [](double alpha, double radius, double rec) {
    return FilterSettings{Kernel::kGaussian, alpha, radius, rec, TableForm::kFast};
  };
  return {{"nearest", Method::kNearest, {}},
          {"bilinear", Method::kBilinear, {}},
          {"ewa gaussian", Method::kEwa, default_gaussian()},
          {"ewa paper", Method::kEwa, paper_preset()},
          {"ewa a2 r1 rec 1", Method::kEwa, gaussian(2, 1, 1)},
          {"ewa robidoux", Method::kEwa, robidoux_filter()},
          {"ewa jinc", Method::kEwa, jinc_filter()},
          {"optimal 0.0001", Method::kEwa, optimal_filter(0.0001)},
          {"optimal 0.001", Method::kEwa, optimal_filter(0.001)},
          {"optimal 0.003", Method::kEwa, optimal_filter(0.003)},
          {"optimal 0.01", Method::kEwa, optimal_filter(0.01)}};
}

std::vector<StarRow> measure_stars(const std::vector<Contender>& contenders, int circle, WorkerPool& pool) {
  const Rig shape = paper_shape(circle, circle * 512 / 983);
  std::vector<StarRow> rows;
  for (const int ground : {0, 25}) {
    const std::vector<ImageBuffer> faces = star_faces(shape, ground / 100.0, PixelFormat::kRgbPlanar16);
    const std::vector<Image> images = images_of(faces);
    ImageBuffer frame(PixelFormat::kRgbPlanar16, shape.frame.size);
    // With `seen`, energy is the light that a display makes of samples, not the samples' sum.
    const auto measure = [&](const Contender& contender, const SampleSettings& samples, bool seen,
                             const std::string& how) {
      StarRow row{contender.name + how, ground, 0.0, 0.0, 0};
      Energies energies(shape);
      const auto energy = [seen](double sample) { return seen ? light_of_srgb(sample) : sample; };
      for (int step = 0; step < kSteps; ++step) {
        Rig rig = moved(shape, step);
        rig.filter = contender.filter;
        rig.filter.table = TableForm::kPrecise;
        rig.samples = samples;
        make_frame_warp(rig, contender.method, best_cpu(), pool)->warp(images, frame.pixels());
        energies.add_step(rig, step, energy(std::round(ground / 100.0 * 65535.0) / 65535.0),
                          [&](int x, int y) {
                            return energy(as_const(frame.pixels()).samples<std::uint16_t>(0, y)[x] / 65535.0);
                          });
      }
      energies.summarise(row);
      rows.push_back(row);
    };
    for (const Contender& contender : contenders) measure(contender, {}, false, "");
    for (const Contender& contender : {Contender{"ewa gaussian", Method::kEwa, default_gaussian()},
                                       Contender{"ewa paper", Method::kEwa, paper_preset()},
                                       Contender{"optimal 0.001", Method::kEwa, optimal_filter()}}) {
      measure(contender, {}, true, ", seen as light");
      measure(contender, {.linear_light = true}, true, " in light, seen as light");
    }
    for (const PeerFilter filter : {PeerFilter::kBilinear, PeerFilter::kLanczos4}) {
      StarRow row = peer_row(shape, filter, ground, pool);
      if (!row.contender.empty()) rows.push_back(std::move(row));
    }
  }
  return rows;
}

}  // namespace cupola
