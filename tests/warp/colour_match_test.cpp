// Four sensors that do not agree: they are brought together slowly, and left alone where there is no reason.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/colour_match.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>

#include "pipeline/warp/native_warp.h"
#include "pipeline/warp/view_mix.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using Scene = std::function<Vec3(const Vec3& direction)>;  // 8-bit steps
constexpr YuvColour kColour{YuvMatrix::kBt709, YuvRange::kFull};

Rig four_cameras(double feather_deg = 8.0) {
  Rig rig = test::omnimax_rig({240, 240}, 240, {160, 160}, {"front", "left", "right", "top"});
  for (View& view : rig.views) view.focal = {0.35, 0.35};
  rig.seams.feather_deg = feather_deg;
  return rig;
}

// Bright and dark, coloured, and nowhere clipped.
Vec3 room(const Vec3& d) {
  return {115.0 + 45.0 * d.x + 30.0 * std::sin(9.0 * d.y), 110.0 + 50.0 * d.y + 30.0 * std::sin(8.0 * d.x),
          110.0 - 40.0 * d.z + 30.0 * std::sin(7.0 * d.x + 8.0 * d.y)};
}

// What a sensor makes of colour x: what becomes x again by (gain, offset).
std::vector<NativeBuffer> seen_by(const Rig& rig, const std::vector<ViewColour>& sensors,
                                  const Scene& scene) {
  std::vector<NativeBuffer> faces;
  for (std::size_t v = 0; v < rig.views.size(); ++v) {
    const View& view = rig.views[v];
    faces.emplace_back(NativeLayout::kNv12, kColour, view.size);
    const auto yuv = [&](double x, double y) {
      Vec3 rgb = scene(direction_at(view, {x, y}));
      for (int c = 0; c < 3; ++c) {
        const auto channel = static_cast<std::size_t>(c);
        rgb[c] = (rgb[c] - sensors[v].offset[channel]) / sensors[v].gain[channel];
      }
      const double luma = 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z;
      return Vec3{luma, 128.0 + (rgb.z - luma) / 1.8556, 128.0 + (rgb.x - luma) / 1.5748};
    };
    const auto byte = [](double value) {
      return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
    };
    for (int y = 0; y < view.size.height; ++y) {
      for (int x = 0; x < view.size.width; ++x) {
        *sample_at(faces.back().pixels(), 0, x, y) = byte(yuv(x + 0.5, y + 0.5).x);
        if (x % 2 != 0 || y % 2 != 0) continue;
        const Vec3 chroma = yuv(x + 1.0, y + 1.0);
        *sample_at(faces.back().pixels(), 1, x / 2, y / 2) = byte(chroma.y);
        *sample_at(faces.back().pixels(), 2, x / 2, y / 2) = byte(chroma.z);
      }
    }
  }
  return faces;
}

std::vector<NativeImage> images_of(const std::vector<NativeBuffer>& faces) {
  std::vector<NativeImage> images;
  for (const NativeBuffer& face : faces) images.push_back(face.pixels());
  return images;
}

ViewColour colour(Vec3 gain, double black) {
  ViewColour made;
  for (std::size_t c = 0; c < 3; ++c) {
    made.gain[c] = gain[static_cast<int>(c)];
    made.offset[c] = -black * made.gain[c];
  }
  return made;
}

// Of the gains' geometric mean 1 in every channel.
std::vector<ViewColour> four_sensors() {
  std::vector<ViewColour> sensors = {colour({1.15, 1.1, 0.95}, 3.0), colour({0.9, 1.0, 1.1}, -2.0),
                                     colour({1.0, 0.92, 0.97}, 4.0), colour({0.95, 1.05, 1.08}, -5.0)};
  for (std::size_t c = 0; c < 3; ++c) {
    double product = 1.0;
    for (const ViewColour& sensor : sensors) product *= sensor.gain[c];
    for (ViewColour& sensor : sensors) sensor.gain[c] /= std::pow(product, 0.25);
  }
  return sensors;
}

std::vector<std::optional<ViewColour>> none_locked() {
  return std::vector<std::optional<ViewColour>>(4);
}

// Follows the pictures for `time` at 60 sets a second; `each` sees every set.
void follow(ColourMatch& match, const std::vector<NativeImage>& images, std::chrono::nanoseconds& now,
            std::chrono::nanoseconds time, const std::function<void()>& each = {}) {
  for (const auto end = now + time; now < end; now += 16'666'667ns) {
    match.look(images, 0xf, now);
    if (each) each();
  }
}

// The largest difference between what two views make of one direction in their overlap, 8-bit steps.
double disagreement(const Rig& rig, const std::vector<ViewColour>& sensors,
                    std::span<const ViewColour> colours) {
  double most = 0.0;
  for (int i = 0; i < 60 * 60; ++i) {
    DirectionAndSlope looking;
    if (!ray(rig.frame, {4.0 * (i % 60) + 2.0, 4.0 * (i / 60) + 2.0}, looking)) continue;
    double least = HUGE_VAL;
    double largest = -HUGE_VAL;
    for (std::size_t c = 0; c < 3; ++c) {
      least = HUGE_VAL;
      largest = -HUGE_VAL;
      for (std::size_t v = 0; v < 4; ++v) {
        if (!covers(rig.views[v], looking.direction)) continue;
        const double sample =
            (room(looking.direction)[static_cast<int>(c)] - sensors[v].offset[c]) / sensors[v].gain[c];
        least = std::min(least, colours[v].of(c, sample));
        largest = std::max(largest, colours[v].of(c, sample));
      }
      if (largest > least) most = std::max(most, largest - least);
    }
  }
  return most;
}

TEST(ColourMatch, BringsFourSensorsWithin2StepsOfEachOtherInTheirOverlaps) {
  const Rig rig = four_cameras();
  const std::vector<ViewColour> sensors = four_sensors();
  const std::vector<NativeBuffer> faces = seen_by(rig, sensors, room);
  ColourMatch match(rig, NativeLayout::kNv12, kColour, none_locked());
  ASSERT_GE(match.pairs(), 3U);
  EXPECT_GT(disagreement(rig, sensors, match.colours()), 20.0);
  std::chrono::nanoseconds now = 5s;
  follow(match, images_of(faces), now, 60s);
  EXPECT_LT(disagreement(rig, sensors, match.colours()), 2.0);
  for (std::size_t c = 0; c < 3; ++c) {
    double product = 1.0;
    for (const ViewColour& view : match.colours()) product *= view.gain[c];
    EXPECT_NEAR(product, 1.0, 0.02) << "the geometric mean is held";
  }
}

TEST(ColourMatch, LeavesSensorsThatAgreeAlone) {
  const Rig rig = four_cameras();
  const std::vector<NativeBuffer> faces = seen_by(rig, std::vector<ViewColour>(4), room);
  ColourMatch match(rig, NativeLayout::kNv12, kColour, none_locked());
  std::chrono::nanoseconds now = 5s;
  follow(match, images_of(faces), now, 20s);
  for (const ViewColour& view : match.colours()) EXPECT_EQ(view, ViewColour{});
}

// One sensor gains a fifth at once. The mean being held, each of the others takes a quarter of it in the end:
// slowly, one way, and no farther.
TEST(ColourMatch, FollowsAStepInOneSensorSlowlyAndWithoutPumping) {
  const Rig rig = four_cameras();
  std::vector<ViewColour> sensors(4);
  ColourMatch match(rig, NativeLayout::kNv12, kColour, none_locked());
  std::chrono::nanoseconds now = 5s;
  sensors[1] = colour({1.0 / 1.2, 1.0 / 1.2, 1.0 / 1.2}, 0.0);
  const std::vector<NativeBuffer> faces = seen_by(rig, sensors, [](const Vec3& d) { return 0.85 * room(d); });
  std::array<double, 4> last{1.0, 1.0, 1.0, 1.0};
  std::chrono::nanoseconds begun = now;
  follow(match, images_of(faces), now, 40s, [&] {
    for (std::size_t v : {0, 2, 3}) {
      const double level = match.colours()[v].of(1, 100.0) / 100.0;
      ASSERT_GE(level, last[v] - 0.004) << "never back";
      ASSERT_LE(level, std::pow(1.2, 0.25) + 0.015) << "never past it";
      if (now < begun + 1s) {
        ASSERT_LT(level, 1.02) << "not at once";
      }
      last[v] = std::max(last[v], level);
    }
  });
  EXPECT_LT(match.colours()[1].of(1, 100.0), 92.0);
}

// A white board near the cameras, in different places of two of their pictures: a third of an overlap's
// length.
TEST(ColourMatch, IsNotTakenInByWhatMovesThroughTheOverlap) {
  const Rig rig = four_cameras();
  const std::vector<ViewColour> sensors(4);
  ColourMatch match(rig, NativeLayout::kNv12, kColour, none_locked());
  std::chrono::nanoseconds now = 5s;
  for (int step = 0; step < 12; ++step) {
    std::vector<NativeBuffer> faces = seen_by(rig, sensors, room);
    for (std::size_t v = 0; v < 4; v += 2) {
      for (int y = 0; y < 50; ++y) {
        for (int x = 0; x < 50; ++x)
          *sample_at(faces[v].pixels(), 0, (x + 12 * step) % 160, 10 * step + y) = 225;
      }
    }
    follow(match, images_of(faces), now, 2s);
    for (const ViewColour& view : match.colours()) {
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(view.of(c, 100.0), 100.0, 8.0) << step;
    }
  }
}

TEST(ColourMatch, KeepsWhatIsLockedAndBringsTheOthersToIt) {
  const Rig rig = four_cameras();
  const std::vector<ViewColour> sensors = four_sensors();
  const std::vector<NativeBuffer> faces = seen_by(rig, sensors, room);
  auto locked = none_locked();
  locked[2] = sensors[2];
  ColourMatch match(rig, NativeLayout::kNv12, kColour, locked);
  std::chrono::nanoseconds now = 5s;
  follow(match, images_of(faces), now, 60s, [&] { ASSERT_EQ(match.colours()[2], sensors[2]); });
  EXPECT_LT(disagreement(rig, sensors, match.colours()), 2.0);
}

TEST(ColourMatch, HasNoPairsWherePicturesOnlyMeet) {
  Rig rig = four_cameras();
  for (View& view : rig.views) view.focal = {0.5, 0.5};
  ColourMatch match(rig, NativeLayout::kNv12, kColour, none_locked());
  EXPECT_EQ(match.pairs(), 0U);
  EXPECT_FALSE(match.look({}, 0xf, 1s));
}

TEST(ColourMatch, DoesNotReadViewsThatShowNoPictureOfTheSet) {
  const Rig rig = four_cameras();
  std::vector<NativeImage> images = images_of(seen_by(rig, four_sensors(), room));
  for (NativeImage& image : images) image.planes = {};  // it would be seen
  ColourMatch match(rig, NativeLayout::kNv12, kColour, none_locked());
  for (int i = 0; i < 600; ++i) EXPECT_FALSE(match.look(images, 0, i * 16ms));
}

// Through the warp: the room as it is, whatever the sensors made of it, in seams too.
TEST(ViewMix, GivesOnePictureOfFourSensors) {
  WorkerPool pool(1);
  for (const double feather_deg : {0.0, 8.0}) {
    const Rig rig = four_cameras(feather_deg);
    const std::vector<ViewColour> sensors = four_sensors();
    const std::vector<NativeBuffer> faces = seen_by(rig, sensors, room);
    const auto warp = make_native_to_xrgb_warp(rig, NativeLayout::kNv12, best_cpu(), pool);
    ASSERT_TRUE(warp->prepare_colours(rig));
    warp->set_colours(sensors);
    ImageBuffer frame(PixelFormat::kXrgb8888, rig.frame.size);
    warp->warp(images_of(faces), frame.pixels());
    double squares = 0.0;
    int count = 0;
    double most = 0.0;
    double largest = 0.0;
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 240; ++x) {
        DirectionAndSlope looking;
        if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking) || owner(rig.views, looking.direction) < 0) continue;
        std::array<double, 6> shares{};
        Feather(rig.seams).shares(rig.views, looking.direction, shares);
        const auto views =
            std::count_if(shares.begin(), shares.end(), [](double share) { return share > 0.0; });
        const std::uint32_t pixel = frame.pixels().samples<std::uint32_t>(0, y)[x];
        for (int c = 0; c < 3; ++c) {
          const double off = (pixel >> (16 - 8 * c) & 0xff) - room(looking.direction)[c];
          squares += off * off;
          if (views < 3) most = std::max(most, std::abs(off));
          largest = std::max(largest, std::abs(off));
          ++count;
        }
      }
    }
    EXPECT_LT(std::sqrt(squares / count), 1.2);
    EXPECT_LT(largest, 16.0) << "where three views mix the least of them goes by the others' colours";
    EXPECT_LT(most, feather_deg > 0.0 ? 4.0 : 16.0)
        << "without a feather pixels on the line are of both views";
  }
}

TEST(ViewMix, OfViewsOwnColoursGivesTheBitsThatThereWereWithout) {
  WorkerPool pool(1);
  const Rig rig = four_cameras();
  const std::vector<NativeBuffer> faces = seen_by(rig, four_sensors(), room);
  const auto plain = make_native_to_xrgb_warp(rig, NativeLayout::kNv12, best_cpu(), pool);
  const auto mixed = make_native_to_xrgb_warp(rig, NativeLayout::kNv12, best_cpu(), pool);
  ASSERT_TRUE(mixed->prepare_colours(rig));
  ImageBuffer one(PixelFormat::kXrgb8888, rig.frame.size);
  ImageBuffer two(PixelFormat::kXrgb8888, rig.frame.size);
  plain->warp(images_of(faces), one.pixels());
  mixed->warp(images_of(faces), two.pixels());
  EXPECT_TRUE(test::same_pixels(one.pixels(), two.pixels()));
}

}  // namespace
}  // namespace cupola
