// YUV faces warped as they come: exact where it must be, the same bits on every machine, near the reference.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/native_warp.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <random>

#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"
#include "pipeline/warp/yuv_rig.h"
#include "pipeline/warp/yuv_rows.h"
#include "tests/frame/temporary_folder.h"
#include "tests/warp/yuv_faces.h"

namespace cupola {
namespace {

constexpr NativeLayout kLayouts[] = {NativeLayout::kNv12, NativeLayout::kI420, NativeLayout::kI422,
                                     NativeLayout::kYuyv, NativeLayout::kUyvy};
constexpr NativeLayout kToXrgb[] = {NativeLayout::kNv12, NativeLayout::kP010, NativeLayout::kI420,
                                    NativeLayout::kI422, NativeLayout::kYuyv, NativeLayout::kUyvy};
constexpr YuvColour kFull601{YuvMatrix::kBt601, YuvRange::kFull};
constexpr YuvColour kLimited709{YuvMatrix::kBt709, YuvRange::kLimited};
const std::vector<std::string> kFour = {"front", "left", "right", "top"};

WorkerPool& pool() {
  static WorkerPool shared(2);
  return shared;
}

void soil(const MutableNativeImage& frame) {
  for (std::size_t p = 0; p < plane_count(frame.layout); ++p) {
    const Size bytes = plane_bytes(frame.layout, frame.size, p);
    for (int y = 0; y < bytes.height; ++y)
      std::fill_n(frame.planes[p].row(y), bytes.width, std::uint8_t{0xa5});
  }
}

NativeBuffer to_nv12(const Rig& rig, std::span<const NativeImage> faces, Cpu cpu,
                     WorkerPool& threads = pool()) {
  NativeBuffer frame(NativeLayout::kNv12, faces[0].colour, rig.frame.size);
  soil(frame.pixels());
  make_nv12_warp(rig, faces[0].layout, cpu, threads)->warp(faces, frame.pixels());
  return frame;
}

ImageBuffer to_xrgb(const Rig& rig, std::span<const NativeImage> faces, Cpu cpu,
                    WorkerPool& threads = pool()) {
  ImageBuffer frame(PixelFormat::kXrgb8888, rig.frame.size);
  for (int y = 0; y < rig.frame.size.height; ++y) {
    std::memset(frame.pixels().planes[0].row(y), 0xa5, static_cast<std::size_t>(rig.frame.size.width) * 4);
  }
  make_native_to_xrgb_warp(rig, faces[0].layout, cpu, threads)->warp(faces, frame.pixels());
  return frame;
}

bool same_planes(const NativeImage& a, const NativeImage& b) {
  for (std::size_t p = 0; p < plane_count(a.layout); ++p) {
    const Size bytes = plane_bytes(a.layout, a.size, p);
    for (int y = 0; y < bytes.height; ++y) {
      if (std::memcmp(a.planes[p].row(y), b.planes[p].row(y), static_cast<std::size_t>(bytes.width)) != 0)
        return false;
    }
  }
  return true;
}

bool covered(const Rig& rig, int x, int y) {
  DirectionAndSlope looking;
  return ray(rig.frame, {x + 0.5, y + 0.5}, looking) && owner(rig.views, looking.direction) >= 0;
}

// A channel of `faces` as grey RGB faces for `rig`, and the frame of those.
ImageBuffer grey_warp(const Rig& rig, const test::YuvFaces& faces, int channel) {
  const test::Faces grey = test::make_faces(rig, [&](int view, int, int x, int y) {
    return unsigned{*sample_at(faces.images[static_cast<std::size_t>(view)], channel, x, y)};
  });
  const WarpTable table = build_warp_table(rig, pool());
  ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
  make_table_warp(table, best_cpu(), pool())->warp(grey.images, frame.pixels());
  return frame;
}

TEST(YuvWarp, ChannelsOfNv12AreToTheBitWhatGreyPicturesGive) {
  struct Case {
    Size frame, face;
    FilterSettings filter;
  };
  FilterSettings precise;
  precise.table = TableForm::kPrecise;
  for (const Case& each : {Case{{333, 205}, {170, 160}, {}}, Case{{200, 150}, {101, 97}, precise},
                           Case{{200, 146}, {128, 128}, paper_preset()}}) {
    Rig rig = test::omnimax_rig(each.frame, each.frame.width, each.face, kFour);
    rig.filter = each.filter;
    for (const NativeLayout layout : kLayouts) {
      const test::YuvFaces faces = test::make_yuv_faces(rig, layout, kFull601, test::noise(5));
      NativeBuffer frame = to_nv12(rig, faces.images, best_cpu());
      const ImageBuffer luma = grey_warp(rig, faces, 0);
      for (int y = 0; y < each.frame.height; ++y) {
        ASSERT_EQ(std::memcmp(frame.pixels().planes[0].row(y), luma.pixels().samples<std::uint8_t>(0, y),
                              static_cast<std::size_t>(each.frame.width)),
                  0);
      }
      const Rig half = half_frame_chroma_rig(rig, layout);
      for (int channel = 1; channel < 3; ++channel) {
        const ImageBuffer chroma = grey_warp(half, faces, channel);
        for (int y = 0; y < half.frame.size.height; ++y) {
          for (int x = 0; x < half.frame.size.width; ++x) {
            const int expected = covered(half, x, y) ? chroma.pixels().samples<std::uint8_t>(0, y)[x] : 128;
            ASSERT_EQ(*sample_at(frame.pixels(), channel, x, y), expected) << x << ' ' << y;
          }
        }
      }
    }
  }
}

TEST(YuvWarp, EvenColoursComeOutUnchangedAndTheRestIsBlack) {
  const Rig rig = test::omnimax_rig({123, 90}, 123, {65, 60}, kFour);
  std::mt19937 random(3);
  std::uniform_int_distribution<unsigned> value(0, 255);
  for (const YuvColour colour : {kFull601, kLimited709}) {
    const YuvToRgb matrix = yuv_to_rgb(colour);
    for (const NativeLayout layout : kLayouts) {
      for (int i = 0; i < 6; ++i) {
        const std::array<unsigned, 3> yuv{value(random), value(random), value(random)};
        const test::YuvFaces faces = test::make_yuv_faces(
            rig, layout, colour,
            [&](int, int channel, int, int) { return yuv[static_cast<std::size_t>(channel)]; });
        const Luma luma = static_cast<Luma>(yuv[0] * 64);
        const Chroma chroma{static_cast<std::uint16_t>(yuv[1] * 64), static_cast<std::uint16_t>(yuv[2] * 64)};
        Xrgb expected = 0;
        kYuvRowsScalar.xrgb(&luma, &chroma, 1, matrix, &expected);
        const ImageBuffer xrgb = to_xrgb(rig, faces.images, best_cpu());
        NativeBuffer nv12 = to_nv12(rig, faces.images, best_cpu());
        const Rig half = half_frame_chroma_rig(rig, layout);
        for (int y = 0; y < 90; ++y) {
          for (int x = 0; x < 123; ++x) {
            const bool in = covered(rig, x, y);
            ASSERT_EQ(xrgb.pixels().samples<Xrgb>(0, y)[x], in ? expected : kBlackXrgb) << x << ' ' << y;
            ASSERT_EQ(*sample_at(nv12.pixels(), 0, x, y), in ? yuv[0] : black_luma(colour.range));
            const bool chroma_in = covered(half, x / 2, y / 2);
            ASSERT_EQ(*sample_at(nv12.pixels(), 1, x / 2, y / 2), chroma_in ? yuv[1] : 128U);
            ASSERT_EQ(*sample_at(nv12.pixels(), 2, x / 2, y / 2), chroma_in ? yuv[2] : 128U);
          }
        }
      }
    }
  }
}

TEST(YuvWarp, EveryKernelGivesTheScalarBitsOverRandomRigsAndSizes) {
  std::mt19937 random(17);
  for (int i = 0; i < 16; ++i) {
    const auto side = [&](int least, int most) {
      return std::uniform_int_distribution<>(least, most)(random);
    };
    Rig rig =
        test::omnimax_rig({side(1, 150), side(1, 150)}, side(20, 200), {side(1, 120), side(1, 120)}, kFour);
    rig.filter.radius = std::uniform_real_distribution<>(0.5, 2.5)(random);
    rig.filter.rec = i % 3 == 0 ? 1.0 : 0.0;
    rig.filter.table = i / 4 % 2 == 0 ? TableForm::kFast : TableForm::kPrecise;
    const NativeLayout layout = kLayouts[i % 4];
    for (const test::TexelFunction& texel : {test::noise(static_cast<unsigned>(i)), test::checkerboard(1),
                                             test::TexelFunction([](int, int, int, int) { return 255U; }),
                                             test::TexelFunction([](int, int, int, int) { return 0U; })}) {
      const test::YuvFaces faces = test::make_yuv_faces(rig, layout, kLimited709, texel);
      NativeBuffer nv12 = to_nv12(rig, faces.images, Cpu::kScalar);
      const ImageBuffer xrgb = to_xrgb(rig, faces.images, Cpu::kScalar);
      for (const Cpu cpu : {Cpu::kSse4, Cpu::kAvx2, Cpu::kAvx512, Cpu::kNeon}) {
        if (!supported(cpu)) continue;
        ASSERT_TRUE(same_planes(as_const(nv12.pixels()), as_const(to_nv12(rig, faces.images, cpu).pixels())))
            << i << ' ' << name(cpu);
        ASSERT_TRUE(test::same_pixels(xrgb.pixels(), to_xrgb(rig, faces.images, cpu).pixels()))
            << i << ' ' << name(cpu);
      }
    }
  }
}

TEST(YuvWarp, LayoutsOfTheSameSamplesGiveTheSameFramesWithAnyNumberOfThreads) {
  const Rig rig = test::omnimax_rig({200, 146}, 200, {122, 98}, kFour);
  WorkerPool five(5);
  for (const auto& [a, b] : {std::pair(NativeLayout::kNv12, NativeLayout::kI420),
                             std::pair(NativeLayout::kYuyv, NativeLayout::kUyvy),
                             std::pair(NativeLayout::kYuyv, NativeLayout::kI422)}) {
    const test::YuvFaces first = test::make_yuv_faces(rig, a, kLimited709, test::noise(8));
    const test::YuvFaces second = test::make_yuv_faces(rig, b, kLimited709, test::noise(8));
    EXPECT_TRUE(same_planes(as_const(to_nv12(rig, first.images, best_cpu()).pixels()),
                            as_const(to_nv12(rig, second.images, best_cpu(), five).pixels())));
    EXPECT_TRUE(test::same_pixels(as_const(to_xrgb(rig, first.images, best_cpu()).pixels()),
                                  as_const(to_xrgb(rig, second.images, best_cpu(), five).pixels())));
  }
}

// Planes whose last (or first) byte is next to a page that must not be touched, with rows apart by `gap`.
class GuardedFace {
 public:
  GuardedFace(const NativeImage& from, int gap, bool at_end) : image_(from) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    for (std::size_t p = 0; p < plane_count(from.layout); ++p) {
      const Size bytes = plane_bytes(from.layout, from.size, p);
      const std::size_t stride = static_cast<std::size_t>(bytes.width + gap);
      const std::size_t used =
          stride * static_cast<std::size_t>(bytes.height - 1) + static_cast<std::size_t>(bytes.width);
      const std::size_t pages = (used + page - 1) / page * page;
      auto* memory = static_cast<std::uint8_t*>(
          mmap(nullptr, pages + 2 * page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
      mprotect(memory + page, pages, PROT_READ | PROT_WRITE);
      mapped_[p] = {memory, pages + 2 * page};
      std::uint8_t* first = memory + page + (at_end ? pages - used : 0);
      for (int y = 0; y < bytes.height; ++y) {
        std::memcpy(first + static_cast<std::size_t>(y) * stride, from.planes[p].row(y),
                    static_cast<std::size_t>(bytes.width));
      }
      image_.planes[p] = {first, static_cast<std::ptrdiff_t>(stride)};
    }
  }
  GuardedFace(const GuardedFace&) = delete;
  GuardedFace& operator=(const GuardedFace&) = delete;
  ~GuardedFace() {
    for (const auto& [memory, bytes] : mapped_) {
      if (memory != nullptr) munmap(memory, bytes);
    }
  }
  const NativeImage& image() const { return image_; }

 private:
  NativeImage image_;
  std::array<std::pair<void*, std::size_t>, 3> mapped_{};
};

TEST(YuvWarp, NeedsNoMoreOfAFaceThanItSaysItReads) {
  // Tilted, so that no two faces are needed alike; the last has a face that is not needed at all.
  Rig tilted = test::omnimax_rig({200, 146}, 200, {97, 83}, kFour);
  for (View& view : tilted.views) {
    for (Vec3* axis : {&view.forward, &view.right, &view.up}) {
      *axis = {axis->x, 0.8 * axis->y - 0.6 * axis->z, 0.6 * axis->y + 0.8 * axis->z};
    }
  }
  const Rig plain = test::omnimax_rig({200, 146}, 200, {128, 128}, kFour);
  const Rig spare = test::omnimax_rig({200, 146}, 200, {128, 128}, {"front", "left", "right", "top", "back"});
  std::int64_t spared = 0;
  std::int64_t unneeded = 0;
  for (const Rig& rig : {plain, tilted, spare}) {
    for (const NativeLayout layout : kToXrgb) {
      const test::YuvFaces faces = test::make_yuv_faces(rig, layout, kFull601, test::noise(9));
      const ImageBuffer expected = to_xrgb(rig, faces.images, Cpu::kScalar);
      for (const Cpu cpu : {Cpu::kScalar, best_cpu()}) {
        const auto warp = make_native_to_xrgb_warp(rig, layout, cpu, pool());
        const std::vector<TexelBox> boxes = warp->reads();
        for (const bool at_end : {true, false}) {
          std::vector<std::unique_ptr<GuardedFace>> guarded;
          std::vector<NativeImage> images;
          for (std::size_t v = 0; v < boxes.size(); ++v) {
            const NativeImage& face = faces.images[v];
            const TexelBox box = boxes[v].empty() ? TexelBox{0, 0, 2, 2} : boxes[v];
            unneeded += boxes[v].empty() ? 1 : 0;
            const Size size{box.x1 - box.x0, box.y1 - box.y0};
            spared += face.size.width * face.size.height - size.width * size.height;
            guarded.push_back(std::make_unique<GuardedFace>(part_of(face, box.x0, box.y0, size), 0, at_end));
            images.push_back(whole_of(guarded.back()->image(), box.x0, box.y0, face.size));
          }
          ImageBuffer frame(PixelFormat::kXrgb8888, rig.frame.size);
          warp->warp(images, frame.pixels());
          EXPECT_TRUE(test::same_pixels(expected.pixels(), frame.pixels()));
        }
      }
    }
  }
  EXPECT_GT(spared, 0);
  EXPECT_GT(unneeded, 0);
}

TEST(YuvWarp, ReadsPlanesOfAnyStrideAndNothingBesideThem) {
  for (const Size face : {Size{64, 64}, Size{97, 83}, Size{16, 16}}) {
    const Rig rig = test::omnimax_rig({200, 146}, 200, face, kFour);
    for (const NativeLayout layout : kToXrgb) {
      const test::YuvFaces faces = test::make_yuv_faces(rig, layout, kFull601, test::noise(9));
      const bool nv12 = sample_bytes(layout) == 1;
      NativeBuffer planes = nv12 ? to_nv12(rig, faces.images, Cpu::kScalar) : NativeBuffer();
      const ImageBuffer xrgb = to_xrgb(rig, faces.images, Cpu::kScalar);
      for (const bool at_end : {true, false}) {
        std::vector<std::unique_ptr<GuardedFace>> guarded;
        std::vector<NativeImage> images;
        for (const NativeImage& image : faces.images) {
          guarded.push_back(std::make_unique<GuardedFace>(image, at_end ? 0 : 13, at_end));
          images.push_back(guarded.back()->image());
        }
        EXPECT_TRUE(!nv12 || same_planes(as_const(planes.pixels()),
                                         as_const(to_nv12(rig, images, best_cpu()).pixels())));
        EXPECT_TRUE(test::same_pixels(xrgb.pixels(), to_xrgb(rig, images, best_cpu()).pixels()));
      }
    }
  }
}

TEST(YuvWarp, MapsOfTheWorldNeedEvenSizesForNv12) {
  Rig rig = test::omnimax_rig({101, 50}, 100, {64, 64}, {"front"});
  rig.frame.model = FrameModel::kEquirectangular;
  rig.frame.fov = 3.0;
  EXPECT_ANY_THROW(half_frame_chroma_rig(rig, NativeLayout::kNv12));
  rig.frame.size = {100, 50};
  EXPECT_NO_THROW(half_frame_chroma_rig(rig, NativeLayout::kNv12));
}

// At an odd width the luma could be mirrored and the chroma not: then the luma's table is not kept.
TEST(YuvWarp, MakesTheSameFrameOfTablesFromTheCache) {
  const TemporaryFolder folder;
  for (const int width : {100, 101}) {
    const Rig rig = test::omnimax_rig({330, 242}, 330, {width, 90}, kFour);
    const test::YuvFaces faces = test::make_yuv_faces(rig, NativeLayout::kNv12, kLimited709, test::noise(12));
    const ImageBuffer built = to_xrgb(rig, faces.images, best_cpu());
    for (const int time : {1, 2}) {
      TableCache cache(folder / "c");
      ImageBuffer frame(PixelFormat::kXrgb8888, rig.frame.size);
      make_native_to_xrgb_warp(rig, NativeLayout::kNv12, best_cpu(), pool(), &cache)
          ->warp(faces.images, frame.pixels());
      EXPECT_TRUE(test::same_pixels(as_const(frame.pixels()), built.pixels())) << width;
      EXPECT_EQ(cache.found(), time == 1 ? 0 : width == 100 ? 2 : 1) << width;
      EXPECT_EQ(cache.trouble(), "");
    }
  }
}

TEST(YuvWarp, LeavesTilesThatShowNoChangedViewAndMakesTheFrameOfAFullWarp) {
  std::mt19937 random(3);
  for (const Size frame : {Size{330, 242}, Size{201, 145}, Size{190, 190}}) {
    Rig rig = test::omnimax_rig(frame, frame.width, {100, 90}, kFour);
    if (frame.width == frame.height) rig.frame.center = {95.0, 95.0};
    for (const NativeLayout layout : {NativeLayout::kNv12, NativeLayout::kYuyv}) {
      std::array<test::YuvFaces, 2> pictures = {
          test::make_yuv_faces(rig, layout, kLimited709, test::noise(10)),
          test::make_yuv_faces(rig, layout, kLimited709, test::noise(11))};
      const auto to_planes = frame.width % 2 == 0 ? make_nv12_warp(rig, layout, best_cpu(), pool()) : nullptr;
      const auto to_words = make_native_to_xrgb_warp(rig, layout, best_cpu(), pool());
      NativeBuffer planes(NativeLayout::kNv12, kLimited709, frame);
      ImageBuffer words(PixelFormat::kXrgb8888, frame);
      std::vector<NativeImage> now = pictures[0].images;
      if (to_planes) to_planes->warp(now, planes.pixels());
      const WarpWork all = to_words->warp_changed(now, ~0U, words.pixels());
      EXPECT_EQ(all.skipped, 0);
      std::int64_t skipped = 0;
      for (int round = 0; round < 12; ++round) {
        const unsigned changed = random() % 16;
        for (std::size_t v = 0; v < now.size(); ++v) {
          if ((changed >> v & 1) != 0)
            now[v] =
                pictures[now[v].planes[0].data == pictures[0].images[v].planes[0].data ? 1 : 0].images[v];
        }
        const WarpWork work = to_words->warp_changed(now, changed, words.pixels());
        ASSERT_EQ(work.pieces + work.skipped + work.outside, all.pieces + all.outside);
        ASSERT_TRUE(changed != 0 || work.pieces == 0);
        skipped += work.skipped;
        ASSERT_TRUE(
            test::same_pixels(as_const(words.pixels()), as_const(to_xrgb(rig, now, Cpu::kScalar).pixels())))
            << round << ": " << changed;
        if (!to_planes) continue;
        to_planes->warp_changed(now, changed, planes.pixels());
        NativeBuffer whole = to_nv12(rig, now, best_cpu());
        ASSERT_TRUE(same_planes(as_const(planes.pixels()), as_const(whole.pixels()))) << round;
      }
      EXPECT_GT(skipped, 0);
    }
  }
}

}  // namespace
}  // namespace cupola
