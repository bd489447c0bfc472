// What must hold for every rig: even colours to the bit, sound tables, seams that show nothing.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "pipeline/optics/frame_map.h"
#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/footprint.h"
#include "pipeline/warp/symmetry.h"
#include "pipeline/warp/table_build.h"
#include "tests/stress/random_rigs.h"
#include "tests/warp/block_check.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

// A rig that is small enough to be warped whole.
Rig small_rig(test::Dice& dice) {
  Rig rig = test::random_rig(dice);
  for (View& view : rig.views) view.size = {dice.whole(1, 90), dice.whole(1, 90)};
  if (rig.frame.model == FrameModel::kCube) {
    const Size cell{dice.whole(1, 30), dice.whole(1, 30)};
    for (View& face : rig.frame.faces) face.size = cell;
    rig.frame.size = {cell.width * rig.frame.columns,
                      cell.height * static_cast<int>(rig.frame.faces.size()) / rig.frame.columns};
  } else {
    rig.frame.size = {dice.whole(1, 110), dice.whole(1, 90)};
    rig.frame.center = {rig.frame.size.width / 2.0, rig.frame.size.height / 2.0};
    rig.frame.radius = dice.real(0.5, 60.0);
  }
  return rig;
}

TEST(InvariantStress, TablesOfRandomRigsKeepTheirPromises) {
  WorkerPool pool(0);
  std::array<std::int64_t, kBlockKinds> kinds{};
  for (int i = 0; i < 20; ++i) {
    SCOPED_TRACE(i);
    test::Dice dice(static_cast<std::uint64_t>(1000 + i));
    Rig rig = small_rig(dice);
    if (i % 4 == 0) rig.filter = paper_preset();
    if (i % 4 == 1) {
      const double radius = dice.one_in(2) ? 8.0 : 0.25;
      rig.filter = {Kernel::kGaussian, dice.one_in(2) ? 1.0 : 0.01, radius, rig.filter.rec, rig.filter.table};
    }
    if (i % 4 == 2) rig.filter = optimal_filter();
    const WarpTable table = build_warp_table(rig, pool);
    test::expect_sound(table);
    if (HasFatalFailure()) return;
    for (std::size_t kind = 0; kind < kBlockKinds; ++kind) kinds[kind] += table.blocks_of_kind[kind];
  }
  EXPECT_GT(kinds[static_cast<int>(BlockKind::kNarrow8)], 0);
  EXPECT_GT(kinds[static_cast<int>(BlockKind::kSigned8)], 0);
  EXPECT_GT(kinds[static_cast<int>(BlockKind::kNarrow16)], 0);
  EXPECT_GT(kinds[static_cast<int>(BlockKind::kWide16)], 0);
}

TEST(InvariantStress, EvenColoursComeOutToTheBitByEveryMethod) {
  WorkerPool pool(0);
  for (int i = 0; i < 8; ++i) {
    test::Dice dice(static_cast<std::uint64_t>(2000 + i));
    Rig rig = small_rig(dice);
    for (View& view : rig.views) {  // the reference takes long through lenses that bend
      if (view.distortion != Distortion::kNone) view.size = {dice.whole(1, 16), dice.whole(1, 16)};
    }
    const FrameMap map = map_frame(rig, pool);
    for (std::size_t method = 0; method < std::size(kMethodNames); ++method) {
      SCOPED_TRACE(std::string(kMethodNames[method]) + " " + std::to_string(i));
      const auto warp = make_frame_warp(rig, static_cast<Method>(method), best_cpu(), pool);
      for (const unsigned value : {1U, 127U, 254U, 255U}) {
        const test::Faces faces = test::make_faces(rig, [&](int, int, int, int) { return value; });
        ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
        warp->warp(faces.images, frame.pixels());
        for (int y = 0; y < rig.frame.size.height; ++y) {
          for (int x = 0; x < rig.frame.size.width; ++x) {
            const bool covered = map.at(x, y) < FrameMap::kUncovered;
            ASSERT_EQ(frame.pixels().samples<std::uint8_t>(1, y)[x], covered ? value : 0U) << x << ' ' << y;
          }
        }
      }
    }
  }
}

// Even sizes, round lens, five faces, any filter: the mirrored world gives the mirrored frame.
TEST(InvariantStress, MirrorSymmetryIsExact) {
  WorkerPool pool(0);
  for (int i = 0; i < 6; ++i) {
    SCOPED_TRACE(i);
    test::Dice dice(static_cast<std::uint64_t>(3000 + i));
    const Size size{2 * dice.whole(1, 80), 2 * dice.whole(1, 60)};
    const Size face{dice.whole(8, 120), dice.whole(8, 120)};
    Rig rig = test::omnimax_rig(size, std::min(size.width, size.height), face,
                                {"front", "left", "right", "top", "bottom"});
    rig.frame.center = {size.width / 2.0, size.height / 2.0};
    rig.frame.lens = test::random_lens(dice);
    const FilterSettings lobed[] = {robidoux_filter(), jinc_filter(), optimal_filter()};
    if (i % 2 == 1) {
      rig.filter = lobed[i / 2];
    } else {
      rig.filter.radius = dice.real(0.5, 2.5);
    }
    const WarpTable table = build_warp_table(rig, pool);
    ASSERT_EQ(table.reflections.size(), 4U);
    const test::Faces faces = test::make_faces(rig, test::noise(static_cast<unsigned>(i)));
    const auto warp = make_table_warp(table, best_cpu(), pool);
    ImageBuffer frame(PixelFormat::kRgbPlanar8, size);
    warp->warp(faces.images, frame.pixels());
    for (const Reflection& reflection : table.reflections) {
      const test::Faces seen = test::make_faces(rig, [&](int view, int channel, int x, int y) {
        const Reflection::Partner& partner = reflection.views[static_cast<std::size_t>(view)];
        return unsigned{faces.images[partner.view].samples<std::uint8_t>(
            channel, partner.flip_v ? face.height - 1 - y : y)[partner.flip_u ? face.width - 1 - x : x]};
      });
      ImageBuffer mirrored(PixelFormat::kRgbPlanar8, size);
      warp->warp(seen.images, mirrored.pixels());
      for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
          ASSERT_EQ(
              mirrored.pixels().samples<std::uint8_t>(0, y)[x],
              frame.pixels().samples<std::uint8_t>(
                  0, reflection.down ? size.height - 1 - y : y)[reflection.across ? size.width - 1 - x : x]);
        }
      }
    }
  }
}

// A picture that rises by 1 a radian at most, weighed in doubles.
double smooth_value(const Rig& rig, const FootprintGatherer& gatherer, int x, int y) {
  std::vector<Tap> taps;
  gatherer.gather(x, y, taps);
  double sum = 0.0;
  for (const Tap& tap : taps) {
    const Vec3 d = direction_at(rig.views[static_cast<std::size_t>(tap.view)], {tap.x + 0.5, tap.y + 0.5});
    sum += tap.weight * glm::dot(d, Vec3{0.48, 0.64, 0.6});
  }
  return sum;
}

// Pixels on cube edges, before and after the cube turns by a millionth of a texel, so that their home
// changes. Neither the other plane nor a texel that enters or leaves at the rim may show: bounds in texels of
// the picture's steepest slope.
TEST(InvariantStress, SmoothPicturesDoNotShowWhichViewAPixelBelongsTo) {
  double largest_turn = 0.0;
  double largest_step = 0.0;
  int changed_home = 0;
  for (int i = 0; i < 400; ++i) {
    test::Dice dice(static_cast<std::uint64_t>(4000 + i));
    constexpr int kSide = 256;
    Rig rig = test::omnimax_rig({400, 400}, 400, {kSide, kSide},
                                {"front", "left", "right", "top", "bottom", "back"});
    if (i % 2 == 1) rig.filter = paper_preset();
    if (i % 8 == 5) rig.filter = optimal_filter();
    if (i % 8 == 7) rig.filter = robidoux_filter();
    const double texel = 2.0 / kSide;  // radians, at the face's middle
    const double slant = dice.real(-0.9, 0.9);
    if (!test::aim(rig, glm::normalize(Vec3{i % 4 < 2 ? 1.0 : -1.0, slant, -1.0}), 200, 200)) continue;
    const FootprintGatherer gatherer(rig);
    const double before = smooth_value(rig, gatherer, 200, 200);
    double values[2];
    int homes[2];
    const std::vector<View> views = rig.views;
    for (int side = 0; side < 2; ++side) {
      const double angle = (side == 0 ? 1e-6 : -1e-6) * texel;
      for (std::size_t v = 0; v < views.size(); ++v) {
        const auto turned = [&](const Vec3& d) {
          return Vec3{d.x * std::cos(angle) + d.z * std::sin(angle), d.y,
                      d.z * std::cos(angle) - d.x * std::sin(angle)};
        };
        rig.views[v].forward = turned(views[v].forward);
        rig.views[v].right = turned(views[v].right);
        rig.views[v].up = turned(views[v].up);
      }
      DirectionAndSlope looking;
      ASSERT_TRUE(ray(rig.frame, {200.5, 200.5}, looking));
      homes[side] = owner(rig.views, looking.direction);
      values[side] = smooth_value(rig, gatherer, 200, 200);
    }
    rig.views = views;
    changed_home += homes[0] != homes[1] ? 1 : 0;
    largest_turn = std::max(
        {largest_turn, std::abs(values[0] - values[1]) / texel, std::abs(values[0] - before) / texel});
    // Neighbours on both sides of the seam, against the picture itself.
    DirectionAndSlope left;
    DirectionAndSlope right;
    ASSERT_TRUE(ray(rig.frame, {199.5, 200.5}, left) && ray(rig.frame, {201.5, 200.5}, right));
    const double rise = glm::dot(right.direction - left.direction, Vec3{0.48, 0.64, 0.6});
    const double got = smooth_value(rig, gatherer, 201, 200) - smooth_value(rig, gatherer, 199, 200);
    largest_step = std::max(largest_step, std::abs(got - rise) / texel);
  }
  std::printf(
      "seams: a turn changes pixels by at most %.4f texels of slope, neighbours by %.4f; %d changed home\n",
      largest_turn, largest_step, changed_home);
  EXPECT_GT(changed_home, 300);
  EXPECT_LT(largest_turn, 0.05);
  EXPECT_LT(largest_step, 0.5);
}

}  // namespace
}  // namespace cupola
