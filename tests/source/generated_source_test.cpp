// Generated faces against their worlds' formulas, and the promises of the source that draws them.
// SPDX-License-Identifier: MIT
#include "pipeline/source/generated_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>

#include "pipeline/portable/portable_math.h"
#include "pipeline/source/ground_truth.h"
#include "pipeline/source/lettering.h"

namespace cupola {
namespace {

std::vector<View> cube(int size) {
  std::vector<View> views;
  for (const char* name : {"front", "left", "right", "top", "bottom", "back"}) {
    View view;
    view.name = name;
    named_pose(name, view);
    view.size = {size, size};
    views.push_back(view);
  }
  return views;
}

std::vector<NeededRegion> all_of(std::span<const View> views) {
  std::vector<NeededRegion> needed;
  for (const View& view : views) needed.push_back(NeededRegion::all(view.size));
  return needed;
}

GeneratedSource source_of(std::string_view world, std::span<const View> views, WorkerPool& pool,
                          PixelFormat format = PixelFormat::kRgbPlanar8) {
  return GeneratedSource(views, Mat3{1.0}, make_world(world), 60.0, pool, {256, 256}, format);
}

Vec3 texel(const Image& face, int x, int y) {
  Vec3 colour;
  for (int p = 0; p < 3; ++p) colour[p] = face.samples<std::uint8_t>(p, y)[x];
  return colour;
}

double largest(const Vec3& v) {
  return std::max(std::abs(v.x), std::max(std::abs(v.y), std::abs(v.z)));
}

std::string bits(const FaceSet& set) {
  std::string all;
  for (const Image& face : set.faces) {
    for (int p = 0; p < 3; ++p) {
      for (int y = 0; y < face.size.height; ++y) {
        all.append(reinterpret_cast<const char*>(face.planes[static_cast<std::size_t>(p)].row(y)),
                   static_cast<std::size_t>(face.size.width * sample_bytes(face.format)));
      }
    }
  }
  return all;
}

Vec3 towards(double azimuth_deg, double elevation_deg) {
  return upright_label("", azimuth_deg, elevation_deg, 0.0).centre;
}

// The texel of the owning view that sees `d`.
Vec3 seen_at(const FaceSet& set, std::span<const View> views, const Vec3& d) {
  const int view = owner(views, d);
  Vec2 uv;
  EXPECT_TRUE(project(views[static_cast<std::size_t>(view)], d, uv));
  return texel(set.faces[static_cast<std::size_t>(view)], static_cast<int>(uv.x), static_cast<int>(uv.y));
}

class EveryWorld : public testing::TestWithParam<std::string_view> {};

TEST_P(EveryWorld, TexelsAreTheMeanOfTheFormulaOverTheirArea) {
  WorkerPool pool(2);
  const auto views = cube(1024);
  std::vector<View> front(views.begin(), views.begin() + 1);
  auto needed = std::vector{NeededRegion::none(front[0].size)};
  for (int y = 5; y < 1024; y += 93) needed[0].rows[static_cast<std::size_t>(y)] = {300, 800};
  GeneratedSource source = source_of(GetParam(), front, pool);
  source.prepare(needed);
  FaceSet set;
  ASSERT_EQ(source.fetch(90, set), Fetch::kNew);
  const auto world = make_world(GetParam());
  const Instant instant(*world, 1.5);
  double worst = 0.0, squares = 0.0;
  int count = 0;
  for (int y = 5; y < 1024; y += 93) {
    for (int x = 300; x < 800; x += 3) {
      const Vec3 truth = 255.0 * mean_over(front[0], {x, y}, {1.0, 1.0}, instant, 32);
      const double error = largest(texel(set.faces[0], x, y) - truth);
      worst = std::max(worst, error);
      squares += error * error;
      ++count;
    }
  }
  // A hard edge may cut off a corner between the first few samples, and leaves may hide there.
  const bool leafy = GetParam() == "tree", hard = leafy || GetParam() == "rotated-checker";
  EXPECT_LT(worst, leafy ? 64.0 : hard ? 12.0 : 6.0);
  EXPECT_LT(std::sqrt(squares / count), leafy ? 2.0 : 0.7);
}
INSTANTIATE_TEST_SUITE_P(GeneratedSource, EveryWorld, testing::ValuesIn(world_names()),
                         [](const auto& world) {
                           std::string name(world.param);
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

TEST(GeneratedSource, DrawsNothingThatIsNotNeededAndCountsIt) {
  WorkerPool pool(2);
  const auto views = cube(128);
  auto needed = all_of(views);
  needed[0] = NeededRegion::none({128, 128});
  for (int y = 20; y < 60; ++y) needed[0].rows[static_cast<std::size_t>(y)] = {30, 40 + y};
  GeneratedSource whole = source_of("demo", views, pool), part = source_of("demo", views, pool);
  whole.prepare(all_of(views));
  part.prepare(needed);
  EXPECT_EQ(whole.texels_skipped(), 0);
  EXPECT_EQ(part.texels_drawn(), needed[0].texels() + 5 * 128 * 128);
  EXPECT_EQ(part.texels_skipped(), 128 * 128 - needed[0].texels());
  FaceSet of_whole, of_part;
  for (const std::int64_t frame : {0, 100, 400}) {
    whole.fetch(frame, of_whole);
    part.fetch(frame, of_part);
    for (int y = 0; y < 128; ++y) {
      const RowSpan row = needed[0].rows[static_cast<std::size_t>(y)];
      for (int x = 0; x < 128; ++x) {
        const bool inside = x >= row.first && x < row.last;
        EXPECT_EQ(texel(of_part.faces[0], x, y), inside ? texel(of_whole.faces[0], x, y) : Vec3{0.0});
      }
    }
  }
}

TEST(GeneratedSource, AFrameHasTheSameBitsWhateverWasFetchedBefore) {
  WorkerPool pool(2);
  const auto views = cube(96);
  GeneratedSource wandering = source_of("demo", views, pool);
  wandering.prepare(all_of(views));
  FaceSet set;
  for (const std::int64_t frame : {0, 1, 2, 900, 3, 100000, 7, 2}) {
    wandering.fetch(frame, set);
    GeneratedSource fresh = source_of("demo", views, pool);
    fresh.prepare(all_of(views));
    FaceSet full;
    EXPECT_EQ(fresh.fetch(frame, full), Fetch::kNew);
    EXPECT_TRUE(bits(set) == bits(full)) << "frame " << frame;
  }
}

TEST(GeneratedSource, SaysSoWhenNothingMoved) {
  WorkerPool pool(1);
  const auto views = cube(64);
  FaceSet set;
  GeneratedSource still = source_of("grid", views, pool);
  still.prepare(all_of(views));
  EXPECT_EQ(still.fetch(0, set), Fetch::kNew);
  EXPECT_EQ(still.fetch(1, set), Fetch::kUnchanged);
  EXPECT_EQ(set.frame, 1);
  GeneratedSource demo = source_of("demo", views, pool);
  demo.prepare(all_of(views));
  EXPECT_EQ(demo.fetch(0, set), Fetch::kNew);
  EXPECT_EQ(demo.fetch(0, set), Fetch::kUnchanged);
  EXPECT_EQ(demo.fetch(1, set), Fetch::kNew);
}

TEST(GeneratedSource, RedrawsOnlyWhatMoves) {
  WorkerPool pool(2);
  const auto views = cube(512);
  GeneratedSource demo = source_of("demo", views, pool);
  demo.prepare(all_of(views));
  FaceSet set;
  demo.fetch(0, set);
  demo.fetch(1, set);
  EXPECT_GT(demo.texels_redrawn(), 2'000);
  EXPECT_LT(demo.texels_redrawn(), 20'000);  // of one and a half million
}

TEST(GeneratedSource, ThreadsDoNotMatter) {
  WorkerPool one(1), three(3);
  const auto views = cube(90);
  for (const std::string_view world : {"demo", "tree"}) {
    GeneratedSource alone = source_of(world, views, one), shared = source_of(world, views, three);
    alone.prepare(all_of(views));
    shared.prepare(all_of(views));
    FaceSet of_alone, of_shared;
    alone.fetch(77, of_alone);
    shared.fetch(77, of_shared);
    EXPECT_TRUE(bits(of_alone) == bits(of_shared)) << world;
  }
}

TEST(GeneratedSource, SixteenBitsRoundToTheEight) {
  WorkerPool pool(2);
  const auto views = cube(128);
  GeneratedSource narrow = source_of("demo", views, pool);
  GeneratedSource wide = source_of("demo", views, pool, PixelFormat::kRgbPlanar16);
  narrow.prepare(all_of(views));
  wide.prepare(all_of(views));
  FaceSet of_narrow, of_wide;
  narrow.fetch(33, of_narrow);
  wide.fetch(33, of_wide);
  for (std::size_t f = 0; f < views.size(); ++f) {
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 128; ++x) {
        const int value = of_wide.faces[f].samples<std::uint16_t>(1, y)[x];
        EXPECT_EQ(of_narrow.faces[f].samples<std::uint8_t>(1, y)[x], (value + 128) / 257);
      }
    }
  }
}

TEST(GeneratedSource, FacesAgreeAlongTheEdgesTheyShare) {
  WorkerPool pool(2);
  const auto views = cube(256);
  for (const std::string_view world : {"demo", "grid"}) {
    GeneratedSource source = source_of(world, views, pool);
    source.prepare(all_of(views));
    FaceSet set;
    source.fetch(50, set);
    // Front's left column meets left's right one, its top row top's bottom one.
    double sum = 0.0;
    for (int i = 0; i < 256; ++i) {
      sum += largest(texel(set.faces[0], 0, i) - texel(set.faces[1], 255, i));
      sum += largest(texel(set.faces[0], i, 0) - texel(set.faces[3], i, 255));
    }
    EXPECT_LT(sum / 512, 8.0) << world;
  }
}

TEST(GeneratedSource, LandmarksAreWhereTheConventionsPutThem) {
  WorkerPool pool(2);
  const auto views = cube(256);
  FaceSet set;
  GeneratedSource bars = source_of("bars", views, pool);
  bars.prepare(all_of(views));
  bars.fetch(0, set);
  // Eight bars from the left's middle over the front to the right's; white, yellow, cyan, green, magenta,
  // red, blue.
  EXPECT_EQ(seen_at(set, views, towards(-80.0, 10.0)), Vec3(191.0));
  EXPECT_EQ(seen_at(set, views, towards(-56.0, 10.0)), Vec3(191.0, 191.0, 0.0));
  EXPECT_EQ(seen_at(set, views, towards(-11.0, 30.0)), Vec3(0.0, 191.0, 0.0));
  EXPECT_EQ(seen_at(set, views, towards(11.0, 30.0)), Vec3(191.0, 0.0, 191.0));
  EXPECT_EQ(seen_at(set, views, towards(56.0, 60.0)), Vec3(0.0, 0.0, 191.0));
  EXPECT_EQ(texel(set.faces[0], 100, 75),
            Vec3(0.0, 191.0, 0.0));  // front, left of the middle, above the horizon
  EXPECT_EQ(texel(set.faces[1], 190, 75), Vec3(191.0, 191.0, 0.0));  // left, towards the front

  GeneratedSource demo = source_of("demo", views, pool);
  demo.prepare(all_of(views));
  demo.fetch(0, set);
  const Vec3 sunset = seen_at(set, views, towards(-35.0, 9.0)),
             night = seen_at(set, views, towards(145.0, 65.0));
  EXPECT_GT(sunset.x, sunset.z);  // red in the left half of the front
  EXPECT_LT(largest(night), 90.0);
  EXPECT_GT(night.z, night.x);
}

TEST(GeneratedSource, AnAxisTiltedUpSeesTheHorizonLower) {
  WorkerPool pool(1);
  const auto views = cube(512);
  const std::vector<View> front(views.begin(), views.begin() + 1);
  const double tilt = portable::radians(11.0), c = std::cos(tilt), s = std::sin(tilt);
  GeneratedSource bars(front, Mat3{Vec3{1, 0, 0}, Vec3{0, c, s}, Vec3{0, -s, c}}, make_world("bars"), 60.0,
                       pool);
  bars.prepare(std::vector{NeededRegion::all({512, 512})});
  FaceSet set;
  bars.fetch(0, set);
  // The staircase begins 11.5 degrees below the horizon, 22.5 below this axis: at row 256 + 256 tan(22.54
  // deg).
  EXPECT_EQ(texel(set.faces[0], 250, 360), Vec3(0.0, 191.0, 0.0));
  EXPECT_NE(texel(set.faces[0], 250, 364), Vec3(0.0, 191.0, 0.0));
}

TEST(Lettering, ReadsUprightAndUnmirroredFromWithin) {
  // An L: its stem at the left, its foot at the lower right.
  const std::vector<Label> labels = {upright_label("L", 0.0, 0.0, 9.0)};
  const Lettering lettering(labels);
  EXPECT_LT(lettering.distance(towards(-3.0, 2.0)), 0.0);
  EXPECT_LT(lettering.distance(towards(2.0, -4.5)), 0.0);
  EXPECT_EQ(lettering.distance(towards(3.0, 2.0)), Lettering::kFar);
  EXPECT_EQ(lettering.distance(towards(180.0, 0.0)), Lettering::kFar);
}

TEST(DirectionCells, FindEveryConeThatADirectionLiesIn) {
  std::vector<Cone> cones;
  for (int i = 0; i < 200; ++i)
    cones.push_back({towards(i * 37.7, 90.0 * std::sin(i * 1.3)), 0.01 + 0.001 * i});
  const DirectionCells cells(cones, 21);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 d = towards(i * 11.13, 90.0 * std::sin(i * 0.7));
    const auto near = cells.near(d);
    for (std::uint32_t c = 0; c < cones.size(); ++c) {
      if (glm::dot(cones[c].axis, d) >= std::cos(cones[c].angle)) {
        EXPECT_NE(std::find(near.begin(), near.end(), c), near.end());
      }
    }
  }
}

TEST(GroundTruth, FillsTheImageAndNothingElse) {
  WorkerPool pool(2);
  FrameGeometry frame;
  frame.size = {60, 44};
  frame.center = {30.0, 30.0};
  frame.radius = 30.0;
  frame.lens = omnimax_c430();
  const auto world = make_world("white");
  const auto truth = render_truth_exact(frame, Mat3{1.0}, *world, 0.0, 2, pool);
  ASSERT_EQ(truth.size(), 3u * 60 * 44);
  EXPECT_EQ(truth[0], 0.0);
  EXPECT_EQ(truth[30 * 60 + 30], 255.0);
  EXPECT_EQ(render_truth(frame, Mat3{1.0}, *world, 0.0, 2, pool).bytes() > 0, true);
}

TEST(Worlds, AreFoundByNameOnly) {
  EXPECT_EQ(make_world("no such world"), nullptr);
  for (const std::string_view name : world_names()) EXPECT_NE(make_world(name), nullptr) << name;
  WorkerPool pool(1);
  EXPECT_ANY_THROW(source_of("no such world", cube(8), pool));
}

}  // namespace
}  // namespace cupola
