// Skipping what stands and filling what is even: after any edits, found by comparing, the frame is to the bit
// what a full warp makes.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <random>

#include "pipeline/source/face_changes.h"
#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

struct Shape {
  Size frame;
  int circle;
  std::vector<std::string> views;
  Size face;
};

const std::vector<std::string> kFive = {"front", "left", "right", "top", "bottom"};
const Shape kShapes[] = {
    {{200, 146}, 200, {"front", "left", "right", "top"}, {100, 100}},  // one mirror
    {{200, 200}, 200, kFive, {100, 100}},                              // two
    {{201, 145}, 201, kFive, {110, 90}},                               // a middle column
    {{171, 171}, 171, kFive, {90, 90}},                                // and a middle row
    {{190, 130}, 165, {"front", "left", "top"}, {97, 130}},            // none
    {{150, 150}, 150, kFive, {300, 300}},                              // wide footprints
    {{90, 90}, 90, kFive, {5, 7}},                                     // faces smaller than a window
};

Rig rig_of(const Shape& shape) {
  Rig rig = test::omnimax_rig(shape.frame, shape.circle, shape.face, shape.views);
  rig.frame.center = {shape.frame.width / 2.0, shape.frame.height / 2.0};
  return rig;
}

FilterSettings precise(FilterSettings filter) {
  filter.table = TableForm::kPrecise;
  return filter;
}

// A table's warp, its faces now and before, and what is known of them.
class Stand {
 public:
  Stand(const Shape& shape, const FilterSettings& filter, PixelFormat format, unsigned seed,
        const SampleSettings& samples = {})
      : random_(seed), rig_(rig_of(shape)), format_(format) {
    rig_.filter = filter;
    table_ = build_warp_table(rig_, pool_);
    warp_ = make_table_warp(table_, best_cpu(), pool_, samples);
    now_ = test::make_faces(rig_, test::noise(seed, deep() ? 65535 : 255), format);
    before_ = test::make_faces(rig_, test::noise(seed, deep() ? 65535 : 255), format);
    for (const View& view : rig_.views) {
      changed_.emplace_back(view.size);
      even_.emplace_back(view.size);
    }
    look(false);
  }

  bool deep() const { return format_ == PixelFormat::kRgbPlanar16; }
  std::int64_t tiles() const {
    return static_cast<std::int64_t>(table_.tiles.size() * table_.reflections.size());
  }
  std::int64_t empty_tiles() const {
    std::int64_t empty = 0;
    for (const Tile& tile : table_.tiles) empty += tile.block_count == 0 ? 1 : 0;
    return empty * static_cast<std::int64_t>(table_.reflections.size());
  }
  FrameWarp& warp() { return *warp_; }
  std::span<const Image> faces() const { return now_.images; }
  FaceKnowledge known() const { return {changed_, even_}; }

  void edit() {
    const std::size_t view = random_() % rig_.views.size();
    const Size size = rig_.views[view].size;
    switch (random_() % 6) {
      case 0:  // one texel, one step
        put(view, box(size, 1), [](unsigned old) { return old ^ 1; });
        break;
      case 1:  // noise
        put(view, box(size, 20), [&](unsigned) { return static_cast<unsigned>(random_()); });
        break;
      case 2:  // every face black
        for (std::size_t each = 0; each < rig_.views.size(); ++each) even_box(each, {0, 0, 65535, 65535}, 1);
        break;
      case 3:
        even_box(view, {0, 0, size.width, size.height}, 2);
        break;
      default:
        even_box(view, box(size, 80), 2);
    }
  }

  // Compares the faces with those of the last look.
  void look(bool with_changes = true) {
    for (std::size_t i = 0; i < rig_.views.size(); ++i) {
      changed_[i].clear();
      add_changes(before_.images[i], now_.images[i], warp_->needed()[i], changed_[i]);
      even_[i].look(now_.images[i], warp_->needed()[i], with_changes ? &changed_[i] : nullptr);
      convert(now_.images[i], before_.buffers[i].pixels());
    }
  }

 private:
  TexelBox box(Size size, unsigned most) {
    TexelBox box;
    box.x0 = static_cast<int>(random_() % static_cast<unsigned>(size.width));
    box.y0 = static_cast<int>(random_() % static_cast<unsigned>(size.height));
    box.x1 = box.x0 + 1 + static_cast<int>(random_() % most);
    box.y1 = box.y0 + 1 + static_cast<int>(random_() % most);
    return box;
  }
  // One of a few colours, the same in all channels but for one step, perhaps.
  void even_box(std::size_t view, const TexelBox& box, unsigned colours) {
    const unsigned value = static_cast<unsigned>(random_() % colours) * (deep() ? 32767U : 127U);
    put(view, box, [=](unsigned) { return value; });
  }
  template <class Value>
  void put(std::size_t view, const TexelBox& box, Value&& value) {
    const MutableImage& face = now_.buffers[view].pixels();
    for (int channel = 0; channel < 3; ++channel) {
      for (int y = box.y0; y < std::min(box.y1, face.size.height); ++y) {
        for (int x = box.x0; x < std::min(box.x1, face.size.width); ++x) {
          if (deep()) {
            auto& sample = face.samples<std::uint16_t>(channel, y)[x];
            sample = static_cast<std::uint16_t>(value(sample));
          } else {
            auto& sample = face.samples<std::uint8_t>(channel, y)[x];
            sample = static_cast<std::uint8_t>(value(sample));
          }
        }
      }
    }
  }

  std::mt19937 random_;
  WorkerPool pool_{2};
  Rig rig_;
  PixelFormat format_;
  WarpTable table_;
  std::unique_ptr<FrameWarp> warp_;
  test::Faces now_, before_;
  std::vector<ChangedCells> changed_;
  std::vector<EvenCells> even_;
};

class Skipping : public testing::TestWithParam<int> {
 protected:
  const Shape& shape() const { return kShapes[GetParam()]; }
};

void expect_full_warps(Stand& stand, Size frame, PixelFormat format, int rounds) {
  ImageBuffer kept(format, frame);
  ImageBuffer fresh(format, frame);
  stand.warp().warp(stand.faces(), kept.pixels());
  WarpWork sum;
  for (int round = 0; round < rounds; ++round) {
    for (int edits = round % 5; edits > 0; --edits) stand.edit();
    stand.look();
    FaceKnowledge known = stand.known();
    if (round % 7 == 6) known.changed = {};
    const WarpWork work = stand.warp().warp_known(stand.faces(), known, kept.pixels());
    ASSERT_EQ(work.pieces + work.skipped + work.even + work.outside, stand.tiles());
    ASSERT_EQ(work.outside, stand.empty_tiles());
    sum += work;
    stand.warp().warp(stand.faces(), fresh.pixels());
    ASSERT_TRUE(test::same_pixels(as_const(kept.pixels()), as_const(fresh.pixels()))) << round;
  }
  EXPECT_GT(sum.pieces, 0);
  EXPECT_GT(sum.skipped, 0);
  EXPECT_GT(sum.even, 0);
}

TEST_P(Skipping, IsTheFullWarpAfterRandomEdits) {
  for (const FilterSettings& filter :
       {default_gaussian(), precise(default_gaussian()), optimal_filter(), precise(robidoux_filter())}) {
    Stand stand(shape(), filter, PixelFormat::kRgbPlanar8, 7);
    expect_full_warps(stand, shape().frame, PixelFormat::kXrgb8888, 200);
    expect_full_warps(stand, shape().frame, PixelFormat::kRgbPlanar8, 30);
  }
}

TEST_P(Skipping, IsTheFullWarpAfterRandomEditsOf16Bits) {
  for (const FilterSettings& filter : {precise(default_gaussian()), precise(optimal_filter())}) {
    Stand stand(shape(), filter, PixelFormat::kRgbPlanar16, 8);
    expect_full_warps(stand, shape().frame, PixelFormat::kRgb16, 60);
    expect_full_warps(stand, shape().frame, PixelFormat::kXrgb8888, 40);
  }
}

TEST_P(Skipping, IsTheFullWarpAfterRandomEditsInLinearLight) {
  for (const PixelFormat format : {PixelFormat::kRgbPlanar8, PixelFormat::kRgbPlanar16}) {
    Stand stand(shape(), precise(default_gaussian()), format, 9, {.linear_light = true});
    expect_full_warps(stand, shape().frame, PixelFormat::kXrgb8888, 40);
    expect_full_warps(stand, shape().frame, PixelFormat::kRgb16, 20);
  }
}

TEST_P(Skipping, FillsEveryTileOfEvenFacesAndFiltersNone) {
  for (const PixelFormat format : {PixelFormat::kRgbPlanar8, PixelFormat::kRgbPlanar16}) {
    const Rig rig = rig_of(shape());
    WorkerPool pool(1);
    const WarpTable table = build_warp_table(rig, pool);
    const auto warp = make_table_warp(table, best_cpu(), pool);
    const unsigned deep = format == PixelFormat::kRgbPlanar16 ? 257 : 1;
    const test::Faces faces = test::make_faces(
        rig, [=](int, int channel, int, int) { return deep * (50U + 90U * channel); }, format);
    std::vector<EvenCells> even;
    for (std::size_t i = 0; i < rig.views.size(); ++i) {
      even.emplace_back(rig.views[i].size);
      even.back().look(faces.images[i], warp->needed()[i], nullptr);
    }
    ImageBuffer filled(PixelFormat::kRgb16, shape().frame);
    ImageBuffer filtered(PixelFormat::kRgb16, shape().frame);
    const WarpWork work = warp->warp_known(faces.images, {{}, even}, filled.pixels());
    EXPECT_EQ(work.pieces, 0);
    EXPECT_EQ(work.skipped, 0);
    EXPECT_GT(work.even, 0);
    const WarpWork all = warp->warp_known(faces.images, {}, filtered.pixels());
    EXPECT_EQ(all.pieces, work.even);
    EXPECT_EQ(all.outside, work.outside);
    EXPECT_TRUE(test::same_pixels(as_const(filled.pixels()), as_const(filtered.pixels())));
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Skipping, testing::Range(0, static_cast<int>(std::size(kShapes))));

TEST(EveryMethod, LeavesTheFrameWhereNothingChangedAndIsItsFullWarpWhereSomethingDid) {
  const Rig rig = rig_of({{90, 70}, 90, {"front", "left", "right", "top"}, {40, 40}});
  WorkerPool pool(2);
  test::Faces faces = test::make_faces(rig, test::noise(7));
  for (std::size_t i = 0; i < std::size(kMethodNames); ++i) {
    const auto warp = make_frame_warp(rig, static_cast<Method>(i), best_cpu(), pool);
    ImageBuffer kept(PixelFormat::kRgbPlanar8, rig.frame.size);
    ImageBuffer fresh(PixelFormat::kRgbPlanar8, rig.frame.size);
    warp->warp(faces.images, kept.pixels());
    std::vector<ChangedCells> changed(rig.views.size(), ChangedCells(Size{40, 40}));
    const WarpWork none = warp->warp_known(faces.images, {changed, {}}, kept.pixels());
    EXPECT_EQ(none.pieces, 0) << kMethodNames[i];
    EXPECT_GT(none.skipped, 0) << kMethodNames[i];
    faces.buffers[0].pixels().samples<std::uint8_t>(0, 20)[20] ^= 255;
    changed[0].add(20, 20, 21, 21);
    EXPECT_GT(warp->warp_known(faces.images, {changed, {}}, kept.pixels()).pieces, 0) << kMethodNames[i];
    warp->warp(faces.images, fresh.pixels());
    EXPECT_TRUE(test::same_pixels(as_const(kept.pixels()), as_const(fresh.pixels()))) << kMethodNames[i];
  }
}

TEST(EvenCells, KnowTheOneColourOfWhatIsNeeded) {
  const Size size{70, 40};  // three cells across, two down
  ImageBuffer face(PixelFormat::kRgbPlanar8, size);
  EvenCells even(size);
  std::optional<Colour> colour;
  EXPECT_FALSE(even.agree(0, 0, 70, 40, colour)) << "nobody looked";
  even.look(face.pixels(), NeededRegion::all(size), nullptr);
  EXPECT_EQ(even.count(), 6);
  EXPECT_TRUE(even.agree(0, 0, 70, 40, colour));
  EXPECT_EQ(colour, Colour{});
  face.pixels().samples<std::uint8_t>(2, 39)[69] = 1;  // in the last cell
  even.look(face.pixels(), NeededRegion::all(size), nullptr);
  EXPECT_EQ(even.count(), 5);
  EXPECT_TRUE(even.agree(0, 0, 64, 40, colour));
  EXPECT_FALSE(even.agree(0, 0, 65, 40, colour));
  NeededRegion needed = NeededRegion::none(size);
  even.look(face.pixels(), needed, nullptr);
  EXPECT_EQ(even.count(), 0);
  colour.reset();
  EXPECT_TRUE(even.agree(0, 0, 70, 40, colour)) << "nothing is needed";
  EXPECT_FALSE(colour);
  needed.include(69, 39);
  even.look(face.pixels(), needed, nullptr);
  EXPECT_TRUE(even.agree(0, 0, 70, 40, colour));
  EXPECT_EQ(colour, (Colour{0, 0, 1}));
  colour = Colour{0, 0, 2};
  EXPECT_FALSE(even.agree(0, 0, 70, 40, colour)) << "another colour";
  needed.include(68, 39);
  even.look(face.pixels(), needed, nullptr);
  EXPECT_EQ(even.count(), 0);
}

}  // namespace
}  // namespace cupola
