// The preview: the frame scaled small, in parts, and only for somebody who asks.
// SPDX-License-Identifier: MIT
#include "firmware/preview.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "firmware/face_previews.h"
#include "firmware/frame_loop.h"
#include "firmware/show_frames.h"
#include "hal/display/fake_display.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;

// Each pixel says where it is.
ImageBuffer numbered_frame(Size size) {
  ImageBuffer frame(PixelFormat::kXrgb8888, size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      frame.pixels().samples<std::uint32_t>(0, y)[x] =
          0xff000000U | static_cast<std::uint32_t>(y) << 12 | static_cast<std::uint32_t>(x);
    }
  }
  return frame;
}

TEST(Preview, IsTheFrameByItsNearestPixels) {
  const Size size{1966, 1436};
  Preview preview(size);
  ImageBuffer frame = numbered_frame(size);
  ImageBuffer seen;
  EXPECT_EQ(preview.newest(seen), 0);
  std::int64_t bytes = 0;
  for (int i = 0; i < Preview::kParts; ++i) {
    EXPECT_EQ(preview.newest(seen), 0) << "not whole yet";
    EXPECT_TRUE(preview.wants(i * 1ms));
    bytes += preview.copy(as_const(frame.pixels()), i * 1ms);
  }
  ASSERT_EQ(preview.newest(seen), 1);
  EXPECT_EQ(preview.made_at(), 15ms);
  ASSERT_EQ(seen.size(), (Size{480, 350}));
  EXPECT_EQ(bytes, 480 * 350 * 4);
  for (int y = 0; y < 350; ++y) {
    for (int x = 0; x < 480; ++x) {
      const std::uint32_t word = seen.pixels().samples<std::uint32_t>(0, y)[x];
      ASSERT_NEAR(static_cast<double>(word & 0xfff) + 0.5, (x + 0.5) * 1966.0 / 480.0, 0.51);
      ASSERT_NEAR(static_cast<double>(word >> 12 & 0xfff) + 0.5, (y + 0.5) * 1436.0 / 350.0, 0.51);
    }
  }
}

TEST(Preview, OfASmallFrameIsTheFrame) {
  Preview preview({40, 30});
  ImageBuffer frame = numbered_frame({40, 30});
  ImageBuffer seen;
  preview.newest(seen);
  for (int i = 0; i < Preview::kParts; ++i) {
    preview.wants(0ms);
    preview.copy(as_const(frame.pixels()), 0ms);
  }
  ASSERT_EQ(preview.newest(seen), 1);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      ASSERT_EQ(seen.pixels().samples<std::uint32_t>(0, y)[x],
                frame.pixels().samples<std::uint32_t>(0, y)[x]);
    }
  }
}

// All parts of one picture.
ImageBuffer preview_of(const FacePicture& picture, Size size) {
  Preview preview(size);
  ImageBuffer seen;
  preview.newest(seen);
  for (int i = 0; i < Preview::kParts; ++i) {
    preview.wants(0ms);
    preview.copy(picture, 0ms);
  }
  EXPECT_EQ(preview.newest(seen), 1);
  return seen;
}

TEST(Preview, OfAnyFormatIsTheSamePicture) {
  const Size size{20, 12};
  const ImageBuffer frame = numbered_frame(size);
  const ImageBuffer expected = preview_of(frame.pixels(), size);
  for (const PixelFormat format :
       {PixelFormat::kRgbPlanar8, PixelFormat::kRgbPlanar16, PixelFormat::kRgb8, PixelFormat::kRgb16}) {
    ImageBuffer same(format, size);
    convert(frame.pixels(), same.pixels());
    const ImageBuffer seen = preview_of(as_const(same.pixels()), size);
    for (int y = 0; y < size.height; ++y) {
      ASSERT_EQ(std::memcmp(seen.pixels().planes[0].row(y), expected.pixels().planes[0].row(y), 4 * 20), 0)
          << static_cast<int>(format) << ", row " << y;
    }
  }
}

// A grey ramp with a red or blue cast, and of it only a part in memory.
TEST(Preview, OfACamerasPictureIsThePartThatIsThere) {
  const Size size{16, 8};
  for (const NativeLayout layout : {NativeLayout::kNv12, NativeLayout::kP010, NativeLayout::kI420,
                                    NativeLayout::kI422, NativeLayout::kYuyv, NativeLayout::kUyvy,
                                    NativeLayout::kRgb24, NativeLayout::kBgr24, NativeLayout::kXrgb32}) {
    const YuvColour colour{YuvMatrix::kBt709, YuvRange::kFull};
    NativeBuffer buffer(layout, colour, size);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        *sample_at(buffer.pixels(), 0, x, y) = static_cast<std::uint8_t>(40 + 10 * x);
        if (is_rgb(layout)) {
          *sample_at(buffer.pixels(), 1, x, y) = 128;
          *sample_at(buffer.pixels(), 2, x, y) = static_cast<std::uint8_t>(10 * y);
        }
      }
    }
    const Size chroma = chroma_size(layout, size);
    for (int y = 0; y < chroma.height; ++y) {
      for (int x = 0; x < chroma.width; ++x) {
        *sample_at(buffer.pixels(), 1, x, y) = static_cast<std::uint8_t>(100 + 4 * y);
        *sample_at(buffer.pixels(), 2, x, y) = static_cast<std::uint8_t>(120 + 4 * x);
      }
    }
    const TexelBox there{2, 2, 10, 6};
    const ImageBuffer seen = preview_of(NativePart{as_const(buffer.pixels()), there}, size);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        std::array<double, 3> rgb{};
        if (x >= there.x0 && x < there.x1 && y >= there.y0 && y < there.y1) {
          const double first = 40.0 + 10.0 * x;
          const double row = y / (has_chroma_in_every_row(layout) ? 1 : 2);
          const double u = 100.0 + 4.0 * row - 128.0;
          const double v = 120.0 + 4.0 * (x / 2) - 128.0;  // NOLINT(bugprone-integer-division)
          // BT.709 in full range, as its recommendation has it.
          rgb = is_rgb(layout)
                    ? std::array{first, 128.0, 10.0 * y}
                    : std::array{first + 1.5748 * v, first - 0.1873 * u - 0.4681 * v, first + 1.8556 * u};
        }
        const std::uint32_t word = seen.pixels().samples<std::uint32_t>(0, y)[x];
        for (std::size_t c = 0; c < 3; ++c) {
          ASSERT_NEAR(word >> (16 - 8 * c) & 0xff, std::clamp(rgb[c], 0.0, 255.0), 0.52)
              << static_cast<int>(layout) << " at " << x << ", " << y;
        }
      }
    }
  }
}

TEST(Preview, BeginsAgainWhereThePictureHasAnotherSize) {
  Preview preview({100, 100}, 100);
  const ImageBuffer wide = numbered_frame({40, 20});
  const ImageBuffer tall = numbered_frame({200, 400});
  ImageBuffer seen;
  preview.newest(seen);
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(preview.wants(0ms));
    preview.copy(wide.pixels(), 0ms);
  }
  for (int i = 0; i < Preview::kParts; ++i) {
    EXPECT_TRUE(preview.wants(0ms));
    preview.copy(tall.pixels(), 0ms);
  }
  EXPECT_FALSE(preview.wants(0ms));
  ASSERT_EQ(preview.newest(seen), 1);
  EXPECT_EQ(seen.size(), (Size{50, 100}));
  EXPECT_EQ(seen.pixels().samples<std::uint32_t>(0, 0)[0], tall.pixels().samples<std::uint32_t>(0, 2)[2]);
}

class NumberedFaces final : public FrameMaker {
 public:
  Change advance(const Due& /*due*/) noexcept override { return Change::kNew; }
  WarpWork warp(const MutableImage& /*frame*/, int /*age*/) noexcept override { return {}; }
  void shown(std::chrono::nanoseconds /*flipped_at*/) noexcept override {}
  double rate() const override { return 60.0; }
  void report(ShowReport& /*report*/) const noexcept override {}
  FacePicture face(std::size_t view) const noexcept override {
    asked.push_back(view);
    return view < 3 ? FacePicture(frame_.pixels()) : FacePicture();
  }
  mutable std::vector<std::size_t> asked;

 private:
  ImageBuffer frame_ = numbered_frame({400, 200});
};

TEST(FacePreviews, TakeTurnsAndCostNothingUnasked) {
  FacePreviews faces;
  NumberedFaces show;
  EXPECT_EQ(faces.copy(show, 0ms), 0);
  EXPECT_TRUE(show.asked.empty());
  ImageBuffer seen;
  faces.of(0).newest(seen);
  faces.of(2).newest(seen);
  std::int64_t most = 0;
  for (int frame = 0; frame < 2 * Preview::kParts; ++frame) most = std::max(most, faces.copy(show, 0ms));
  EXPECT_LE(most, 4 * 200 * (100 / Preview::kParts + 1)) << "of one face a frame";
  EXPECT_EQ(show.asked.size(), 2u * Preview::kParts);
  EXPECT_EQ(show.asked[0], 0u);
  EXPECT_EQ(show.asked[1], 2u);
  EXPECT_EQ(faces.of(0).newest(seen), 1);
  EXPECT_EQ(faces.of(2).newest(seen), 1);
  EXPECT_EQ(seen.size(), (Size{200, 100}));
  EXPECT_EQ(faces.of(1).newest(seen), 0);
}

class PreviewedShow : public testing::Test {
 protected:
  static Show show(const std::string& world) {
    const std::string lines[] = {
        "rig.frame.width=64",       "rig.frame.height=48", "rig.frame.center=[32, 24]", "rig.frame.radius=30",
        "cue.0.face_size=[32, 32]", "cue.0.duration_s=2",  "cue.0.world=" + world};
    return load_show("demo", lines);
  }
  LoopCounts play(const std::string& world) {
    link_.preview = &preview_;
    ShowFrames frames(show(world), Method::kEwa, Cpu::kScalar, pool_);
    FakeDisplay display(clock_, 64, 48);
    FrameLoop loop(frames, display, clock_, pool_, nullptr, &link_);
    loop.run({});
    const DisplayBuffer front = display.front_buffer();
    last_.assign(front.data, front.data + 48 * front.stride);
    return loop.counts();
  }
  FakeClock clock_;
  WorkerPool pool_{1};
  Preview preview_{{64, 48}};
  ControlLink link_;
  std::vector<std::byte> last_;
  ImageBuffer seen_;
};

TEST_F(PreviewedShow, CostsNothingWhenNobodyAsks) {
  EXPECT_EQ(play("demo").preview_bytes_copied, 0);
}

TEST_F(PreviewedShow, IsMadeOnceForEveryAskingEvenOfAStillPicture) {
  preview_.newest(seen_);
  const LoopCounts counts = play("grid");
  EXPECT_EQ(counts.preview_bytes_copied, 64 * 48 * 4);
  EXPECT_EQ(counts.pixel_bytes_copied, 0);
  EXPECT_EQ(counts.frames_unchanged, 120 - Preview::kParts) << "a still is drawn again for its sake";
  EXPECT_EQ(counts.frames_presented, 120);
  EXPECT_EQ(counts.heap_allocations, 0);
  ASSERT_EQ(preview_.newest(seen_), 1);
  for (int y = 0; y < 48; ++y) {
    ASSERT_EQ(
        std::memcmp(seen_.pixels().planes[0].row(y), &last_[static_cast<std::size_t>(y) * 64 * 4], 64 * 4),
        0);
  }
}

TEST_F(PreviewedShow, IsBlackInABlackout) {
  link_.commands.push({PlayerAction::kBlackout});
  preview_.newest(seen_);
  play("grid");
  ASSERT_EQ(preview_.newest(seen_), 1);
  EXPECT_EQ(seen_.pixels().samples<std::uint32_t>(0, 20)[30], 0xff000000U);
}

}  // namespace
}  // namespace cupola
