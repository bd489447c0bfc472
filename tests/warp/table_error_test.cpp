// The bounds of every table form and kernel on several geometries, from magnification to footprints of
// thousands of texels: against the same kernel unrounded, and against the integral over each pixel.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/footprint.h"
#include "pipeline/warp/table_build.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

WorkerPool& pool() {
  static WorkerPool shared(0);
  return shared;
}

struct Geometry {
  const char* name;
  Rig rig;
};

// `face` texels a side; at 84 a circle of 160 pixels is 1:1.
Rig circle(int pixels, int face) {
  return test::omnimax_rig({pixels, pixels * 3 / 4}, pixels, {face, face}, {"front", "left", "right", "top"});
}

Rig world_map(FrameModel model, Size frame, int face) {
  Rig rig = test::omnimax_rig(frame, frame.width, {face, face},
                              {"front", "left", "right", "top", "bottom", "back"});
  rig.frame.model = model;
  rig.frame.center = {frame.width / 2.0, frame.height / 2.0};
  rig.frame.radius = frame.height / 2.0;
  rig.frame.fov = 6.283185307179586;
  return rig;
}

std::vector<Geometry> geometries() {
  return {{"1:4", circle(160, 21)},
          {"1:1", circle(160, 84)},
          {"2:1", circle(160, 168)},
          {"4:1", circle(120, 252)},
          {"8:1", circle(80, 336)},
          {"32:1", circle(16, 268)},
          {"chrome ball", world_map(FrameModel::kChromeBall, {100, 100}, 64)},
          {"mercator", world_map(FrameModel::kMercator, {150, 75}, 38)},
          {"equirectangular", world_map(FrameModel::kEquirectangular, {150, 75}, 38)}};
}

struct Content {
  const char* name;
  test::Faces (*make)(const Rig&);
};

// A frame whose every value lies half-way between two steps errs by 0.5 however exact its sums are: the means
// of these pictures are not 127.5.
//
// Rings about the middle of each face, as fine as texels allow at the middle of its sides.
unsigned zone_plate(Size face, int x, int y) {
  const double u = x + 0.5 - face.width / 2.0;
  const double v = y + 0.5 - face.height / 2.0;
  return static_cast<unsigned>(127.2 + 127.2 * std::cos(3.14159265358979 * (u * u + v * v) / face.width) +
                               0.5);
}

test::TexelFunction squares(int side) {
  return [side](int, int channel, int x, int y) {
    return ((x / side + y / side) % 2 == 0) != (channel == 1) ? 254U : 0U;
  };
}

const Content kContents[] = {
    {"noise", [](const Rig& rig) { return test::make_faces(rig, test::noise(1)); }},
    {"squares",
     [](const Rig& rig) {
       return test::make_faces(rig, squares(std::max(8, rig.views[0].size.width / 16)));
     }},
    {"texel checker", [](const Rig& rig) { return test::make_faces(rig, squares(1)); }},
    {"zone plate",
     [](const Rig& rig) {
       return test::make_faces(
           rig, [&](int view, int, int x, int y) { return zone_plate(rig.views[view].size, x, y); });
     }},
    {"photograph", [](const Rig& rig) { return test::make_faces(rig, test::photograph(), 1); }},
};

struct Bound {
  const char* name;
  FilterSettings filter;
  double rms, max;
};

FilterSettings precise(FilterSettings filter) {
  filter.table = TableForm::kPrecise;
  return filter;
}

// Footprints of the rig's pixels in doubles, each gathered once; row by row.
std::vector<std::vector<Tap>> footprints(const Rig& rig) {
  const FootprintGatherer gatherer(rig);
  const Size size = rig.frame.size;
  std::vector<std::vector<Tap>> all(static_cast<std::size_t>(size.width) * size.height);
  pool().run(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x)
      gatherer.gather(x, y, all[static_cast<std::size_t>(y) * size.width + x]);
  });
  return all;
}

// Their sums over the faces' texels, as far as 8 bits can show them.
std::vector<double> sums(const std::vector<std::vector<Tap>>& footprints, const test::Faces& faces) {
  std::vector<double> values;
  values.reserve(footprints.size() * 3);
  for (const std::vector<Tap>& taps : footprints) {
    for (int c = 0; c < 3; ++c) {
      double sum = 0.0;
      for (const Tap& tap : taps)
        sum += tap.weight * faces.images[tap.view].samples<std::uint8_t>(c, tap.y)[tap.x];
      values.push_back(std::clamp(sum, 0.0, 255.0));
    }
  }
  return values;
}

// Over the part of the frame that the table holds: the windows of least squares jump by a texel where a
// pixel's centre is between two, and the last bits say which way, in a mirrored half other than in its
// original.
test::Difference difference_of_stored(const WarpTable& table, const Image& frame,
                                      const std::vector<std::vector<Tap>>& footprints,
                                      const std::vector<double>& exact) {
  const Reflection& all = table.reflections.front();
  test::Difference found;
  double squares = 0.0;
  for (int y = 0; y < (all.down ? (frame.size.height + 1) / 2 : frame.size.height); ++y) {
    for (int x = 0; x < (all.across ? (frame.size.width + 1) / 2 : frame.size.width); ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * frame.size.width + x;
      for (int c = 0; c < 3 && !footprints[pixel].empty(); ++c) {
        const double error = std::abs(frame.samples<std::uint8_t>(c, y)[x] - exact[pixel * 3 + c]);
        squares += error * error;
        ++found.samples;
        if (error > found.max) found = {0.0, error, found.samples, x, y};
      }
    }
  }
  found.rms = std::sqrt(squares / static_cast<double>(found.samples));
  return found;
}

class TableError : public testing::TestWithParam<Bound> {};

TEST_P(TableError, StaysWithinItsBoundOfTheUnroundedKernelEverywhere) {
  const Bound& bound = GetParam();
  for (Geometry& geometry : geometries()) {
    Rig& rig = geometry.rig;
    rig.filter = bound.filter;
    const WarpTable table = build_warp_table(rig, pool());
    const auto warp = make_table_warp(table, best_cpu(), pool());
    const auto exact = footprints(rig);
    ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
    std::printf("%-18s %-16s", bound.name, geometry.name);
    for (const Content& content : kContents) {
      const test::Faces faces = content.make(rig);
      warp->warp(faces.images, frame.pixels());
      const test::Difference d = difference_of_stored(table, frame.pixels(), exact, sums(exact, faces));
      std::printf("  %.3f/%.2f", d.rms, d.max);
      EXPECT_LE(d.rms, bound.rms) << geometry.name << ", " << content.name;
      EXPECT_LE(d.max, bound.max) << geometry.name << ", " << content.name << " at " << d.x << ' ' << d.y;
    }
    std::printf("\n");
  }
}

// The bounds are 0.45 / 2 of unsigned and 0.8 / 4 of signed weights of 8 bits, 0.30 / 1 of 16. What is above
// was measured and could not be held: docs/performance.md.
const Bound kBounds[] = {{"gaussian", default_gaussian(), 0.45, 2.0},
                         {"paper", paper_preset(), 0.50, 2.0},
                         {"robidoux", robidoux_filter(), 0.9, 5.5},
                         {"jinc", jinc_filter(), 0.8, 5.5},
                         {"optimal", optimal_filter(), 0.9, 5.5},
                         {"precise_gaussian", precise(default_gaussian()), 0.30, 1.0},
                         {"precise_paper", precise(paper_preset()), 0.30, 1.0},
                         {"precise_robidoux", precise(robidoux_filter()), 0.30, 1.0},
                         {"precise_jinc", precise(jinc_filter()), 0.32, 1.0},
                         {"precise_optimal", precise(optimal_filter()), 0.30, 1.0}};

INSTANTIATE_TEST_SUITE_P(Kernels, TableError, testing::ValuesIn(kBounds),
                         [](const auto& instance) { return instance.param.name; });

// Squares that stand askew, of about 5 pixels.
Vec3 askew(const Vec3& d) {
  const double a = 50.0 * (0.8 * d.x + 0.6 * d.y);
  const double b = 50.0 * (0.8 * d.y - 0.6 * d.x + 0.1 * d.z);
  return Vec3{std::sin(a) * std::sin(b) > 0.0 ? 0.9 : 0.1};
}
Vec3 rings(const Vec3& d) {
  const double angle = std::acos(std::clamp(glm::dot(d, glm::normalize(Vec3{0.3, 0.35, -1.0})), -1.0, 1.0));
  return Vec3{0.5 + 0.45 * std::cos(15.0 * angle * angle)};
}

// The mean over 6 x 6 points of every pixel in the image, 0 to 255; below 0 outside.
std::vector<Vec3> truth(const Rig& rig, const std::function<Vec3(const Vec3&)>& colour) {
  const Size size = rig.frame.size;
  std::vector<Vec3> pixels(static_cast<std::size_t>(size.width) * size.height, Vec3{-1.0});
  pool().run(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      Vec3 sum{0.0};
      bool inside = true;
      for (int sample = 0; sample < 36; ++sample) {
        DirectionAndSlope looking;
        inside = inside &&
                 ray(rig.frame, {x + (sample % 6 + 0.5) / 6, y + (sample / 6 + 0.5) / 6}, looking) &&
                 owner(rig.views, looking.direction) >= 0;
        if (inside) sum += colour(looking.direction);
      }
      if (inside) pixels[static_cast<std::size_t>(y) * size.width + x] = sum * (255.0 / 36);
    }
  });
  return pixels;
}

double psnr(const std::vector<Vec3>& truth, const Image& frame) {
  double squares = 0.0;
  std::int64_t samples = 0;
  for (int y = 0; y < frame.size.height; ++y) {
    for (int x = 0; x < frame.size.width; ++x) {
      const Vec3& exact = truth[static_cast<std::size_t>(y) * frame.size.width + x];
      if (exact.x < 0.0) continue;
      for (int c = 0; c < 3; ++c) {
        const double error = frame.samples<std::uint8_t>(c, y)[x] - exact[c];
        squares += error * error;
        ++samples;
      }
    }
  }
  return 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(samples) / squares);
}

TEST(TableForms, FastIsNearPreciseAgainstTheTruth) {
  // The bound is 0.1 dB. Smooth rings are so near to the truth, 48 to 58 dB, that the rounding of 8-bit
  // weights shows: 0.17 dB were measured with the Gaussian, 1.34 with kernels with lobes.
  struct World {
    const char* name;
    std::function<Vec3(const Vec3&)> colour;
    double decibels, with_lobes;
  };
  const World worlds[] = {{"squares", askew, 0.1, 0.1},
                          {"rings", rings, 0.25, 1.5},
                          {"photograph", test::photograph(), 0.1, 0.1}};
  for (const auto& [name, colour, decibels, with_lobes] : worlds) {
    const std::vector<Vec3> exact = truth(circle(160, 84), colour);
    for (const int face : {84, 168, 336}) {
      Rig rig = circle(160, face);
      const test::Faces faces = test::make_faces(rig, colour);
      for (const Bound& bound : std::span(kBounds).first(5)) {
        double of_form[2] = {};
        for (const TableForm form : {TableForm::kFast, TableForm::kPrecise}) {
          rig.filter = bound.filter;
          rig.filter.table = form;
          const WarpTable table = build_warp_table(rig, pool());
          ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
          make_table_warp(table, best_cpu(), pool())->warp(faces.images, frame.pixels());
          of_form[form == TableForm::kFast ? 0 : 1] = psnr(exact, frame.pixels());
        }
        std::printf("%-10s %d texels, %-9s fast %.2f dB, precise %.2f dB\n", name, face, bound.name,
                    of_form[0], of_form[1]);
        EXPECT_GE(of_form[0], of_form[1] - (bound.filter.kernel == Kernel::kGaussian ? decibels : with_lobes))
            << name << ", " << face << " texels, " << bound.name;
      }
    }
  }
}

}  // namespace
}  // namespace cupola
