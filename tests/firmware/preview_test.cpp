// The preview: the frame scaled small, in parts, and only for somebody who asks.
// SPDX-License-Identifier: MIT
#include "firmware/preview.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

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
