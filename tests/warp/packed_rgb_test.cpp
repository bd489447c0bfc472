// RGB of one plane, warped as it comes: to the bit what planes of the same texels give.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <random>

#include "pipeline/frame/error.h"
#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/native_warp.h"
#include "pipeline/warp/table_build.h"
#include "tests/frame/temporary_folder.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

const std::vector<std::string> kFour = {"front", "left", "right", "top"};
constexpr std::array kLayouts = {NativeLayout::kRgb24, NativeLayout::kBgr24, NativeLayout::kXrgb32};

struct PackedFaces {
  std::vector<NativeBuffer> buffers;
  std::vector<NativeImage> images;
};

// The same texels; what means nothing is noise.
PackedFaces packed(const test::Faces& faces, NativeLayout layout) {
  PackedFaces packed;
  std::mt19937 random(5);
  for (const Image& face : faces.images) {
    packed.buffers.emplace_back(layout, YuvColour{}, face.size);
    const MutableNativeImage& to = packed.buffers.back().pixels();
    for (int y = 0; y < face.size.height; ++y) {
      for (int i = 0; i < plane_bytes(layout, face.size, 0).width; ++i)
        to.planes[0].row(y)[i] = static_cast<std::uint8_t>(random());
      for (int x = 0; x < face.size.width; ++x) {
        for (int channel = 0; channel < 3; ++channel) {
          *sample_at(to, channel, x, y) =
              static_cast<std::uint8_t>(face.planes[static_cast<std::size_t>(channel)].row(y)[x]);
        }
      }
    }
    packed.images.push_back(as_const(to));
  }
  return packed;
}

ImageBuffer frame_of(const Rig& rig, const test::Faces& faces, WorkerPool& pool) {
  ImageBuffer frame(PixelFormat::kXrgb8888, rig.frame.size);
  make_table_warp(build_warp_table(rig, pool), Cpu::kScalar, pool)->warp(faces.images, frame.pixels());
  return frame;
}

TEST(PackedRgb, GivesTheFrameOfPlanesWithEveryKernel) {
  const TemporaryFolder folder;
  WorkerPool pool(2);
  for (const Size face : {Size{160, 160}, Size{97, 123}, Size{16, 9}, Size{6, 5}}) {
    for (const bool signed_weights : {false, true}) {
      Rig rig = test::omnimax_rig({330, 242}, 330, face, kFour);
      if (signed_weights) rig.filter = optimal_filter();
      const test::Faces faces = test::make_faces(rig, test::noise(3, 255), PixelFormat::kRgbPlanar8);
      const ImageBuffer expected = frame_of(rig, faces, pool);
      TableCache cache(folder / "c");  // optimal weights take their time
      for (const NativeLayout layout : kLayouts) {
        const PackedFaces pictures = packed(faces, layout);
        for (const Cpu cpu : {Cpu::kScalar, Cpu::kSse4, Cpu::kAvx2, Cpu::kAvx512, Cpu::kNeon}) {
          if (!supported(cpu)) continue;
          ImageBuffer frame(PixelFormat::kXrgb8888, rig.frame.size);
          make_native_to_xrgb_warp(rig, layout, cpu, pool, &cache)->warp(pictures.images, frame.pixels());
          EXPECT_TRUE(test::same_pixels(as_const(frame.pixels()), expected.pixels()))
              << face.width << " wide, layout " << static_cast<int>(layout) << ", " << name(cpu);
        }
      }
    }
  }
}

TEST(PackedRgb, LeavesTilesThatShowNoChangedView) {
  WorkerPool pool(2);
  const Rig rig = test::omnimax_rig({330, 242}, 330, {100, 90}, kFour);
  const test::Faces before = test::make_faces(rig, test::noise(1, 255), PixelFormat::kRgbPlanar8);
  const test::Faces after = test::make_faces(rig, test::noise(2, 255), PixelFormat::kRgbPlanar8);
  const PackedFaces old_pictures = packed(before, NativeLayout::kBgr24);
  const PackedFaces new_pictures = packed(after, NativeLayout::kBgr24);
  const auto warp = make_native_to_xrgb_warp(rig, NativeLayout::kBgr24, best_cpu(), pool);
  std::int64_t skipped = 0;
  for (unsigned changed = 0; changed < 16; ++changed) {
    test::Faces mixed = test::make_faces(rig, test::noise(1, 255), PixelFormat::kRgbPlanar8);
    std::vector<NativeImage> pictures = old_pictures.images;
    for (std::size_t v = 0; v < pictures.size(); ++v) {
      if ((changed >> v & 1) == 0) continue;
      mixed.images[v] = after.images[v];
      pictures[v] = new_pictures.images[v];
    }
    ImageBuffer frame(PixelFormat::kXrgb8888, rig.frame.size);
    warp->warp(old_pictures.images, frame.pixels());
    skipped += warp->warp_changed(pictures, changed, frame.pixels()).skipped;
    EXPECT_TRUE(test::same_pixels(as_const(frame.pixels()), frame_of(rig, mixed, pool).pixels())) << changed;
  }
  EXPECT_GT(skipped, 0);
}

TEST(PackedRgb, NeedsNoMoreThanItSaysItReads) {
  WorkerPool pool(1);
  const Rig rig = test::omnimax_rig({330, 242}, 330, {101, 91}, kFour);
  const test::Faces faces = test::make_faces(rig, test::noise(3, 255), PixelFormat::kRgbPlanar8);
  const ImageBuffer expected = frame_of(rig, faces, pool);
  for (const NativeLayout layout : kLayouts) {
    const PackedFaces pictures = packed(faces, layout);
    for (const Cpu cpu : {Cpu::kScalar, Cpu::kSse4, Cpu::kAvx2, Cpu::kAvx512, Cpu::kNeon}) {
      if (!supported(cpu)) continue;
      const auto warp = make_native_to_xrgb_warp(rig, layout, cpu, pool);
      const std::vector<TexelBox> boxes = warp->reads();
      std::vector<std::vector<std::uint8_t>> parts(boxes.size());  // each byte of which is watched
      std::vector<NativeImage> images;
      for (std::size_t v = 0; v < boxes.size(); ++v) {
        const TexelBox& box = boxes[v];
        const Size size{box.x1 - box.x0, box.y1 - box.y0};
        const NativeImage from = part_of(pictures.images[v], box.x0, box.y0, size);
        const Size bytes = plane_bytes(layout, size, 0);
        for (int y = 0; y < bytes.height; ++y)
          parts[v].insert(parts[v].end(), from.planes[0].row(y), from.planes[0].row(y) + bytes.width);
        NativeImage part{layout, {}, size, {}};
        part.planes[0] = {parts[v].data(), bytes.width};
        images.push_back(whole_of(part, box.x0, box.y0, rig.views[v].size));
      }
      ImageBuffer frame(PixelFormat::kXrgb8888, rig.frame.size);
      warp->warp(images, frame.pixels());
      EXPECT_TRUE(test::same_pixels(as_const(frame.pixels()), expected.pixels())) << name(cpu);
    }
  }
}

TEST(PackedRgb, IsNotMadeIntoNv12) {
  WorkerPool pool(1);
  const Rig rig = test::omnimax_rig({64, 48}, 64, {32, 32}, kFour);
  EXPECT_THROW(make_nv12_warp(rig, NativeLayout::kRgb24, Cpu::kScalar, pool), InputError);
}

}  // namespace
}  // namespace cupola
