// Live frames in NV12 for displays that take it: to the byte what the slow warp makes, beside frames that are
// mixed, dimmed or drawn in XRGB8888.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "firmware/control_link.h"
#include "firmware/pattern_board.h"
#include "firmware/screenshots.h"
#include "firmware/show_frames.h"
#include "pipeline/frame/error.h"
#include "tests/firmware/live_show.h"
#include "tests/frame/temporary_folder.h"

namespace cupola {
namespace {

using namespace test;
using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

LiveSettings with_nv12() {
  LiveSettings settings;
  settings.nv12 = true;
  return settings;
}

// Luma, then chroma, without what lies between rows.
Bytes bytes_of(const std::byte* luma, const std::byte* chroma, std::ptrdiff_t stride) {
  Bytes bytes(std::size_t{kWidth} * kHeight * 3 / 2);
  for (int y = 0; y < kHeight * 3 / 2; ++y) {
    const std::byte* row = y < kHeight ? luma + y * stride : chroma + (y - kHeight) * stride;
    std::memcpy(&bytes[static_cast<std::size_t>(y) * kWidth], row, kWidth);
  }
  return bytes;
}

class Nv12Frames : public testing::Test {
 protected:
  using Adjust = std::function<void(std::size_t, FakeCameraDevice&, CameraSetup&)>;
  void open(const std::string& cues, const Adjust& adjust = {}) {
    cameras_.emplace(adjust, small_rig(), LiveShow::Wrap{}, LiveColours{}, with_nv12());
    live_ = cameras_->frames.get();
    reference_ = make_nv12_warp(live_->rig(), NativeLayout::kNv12, Cpu::kScalar, cameras_->pool);
    const std::string lines[] = {"rig.frame.width=64", "rig.frame.height=48", "rig.frame.center=[32, 24]",
                                 "rig.frame.radius=30"};
    write_text(folder_ / "show.toml", "rig = \"omnimax\"\n\n" + cues);
    show_ = load_show(folder_ / "show.toml", lines);
    frames_ = std::make_unique<ShowFrames>(show_, Method::kEwa, best_cpu(), cameras_->pool, false, nullptr,
                                           Decoding::kInTurn, std::move(cameras_->frames));
  }

  LoopCounts play(nanoseconds time, const std::function<void(int, const DisplayBuffer&)>& see = {}) {
    SeenDisplay display(cameras_->clock, {kWidth, kHeight}, see);
    if (able_) display.fake().take_nv12();
    FrameLoop loop(*frames_, display, cameras_->clock, cameras_->pool, nullptr, &link_);
    loop.run(time);
    colour_ = display.fake().nv12_colour();
    return loop.counts();
  }

  // All of the cameras' pictures as they are now, by the slow kernel.
  Bytes expected() {
    reference_->warp(live_->faces().faces(), made_.pixels());
    const auto& planes = made_.pixels().planes;
    return bytes_of(reinterpret_cast<const std::byte*>(planes[0].data),
                    reinterpret_cast<const std::byte*>(planes[1].data), planes[0].stride);
  }
  static Bytes seen(const DisplayBuffer& buffer) {
    return bytes_of(buffer.data, buffer.chroma, buffer.stride);
  }

  TemporaryFolder folder_;
  ControlLink link_;
  bool able_ = true;
  ScanoutColour colour_{true, true};
  Show show_;
  std::optional<LiveShow> cameras_;
  LiveFrames* live_ = nullptr;
  std::unique_ptr<ShowFrames> frames_;
  std::unique_ptr<NativeWarp<MutableNativeImage>> reference_;
  NativeBuffer made_{NativeLayout::kNv12, YuvColour{}, {kWidth, kHeight}};
};

const std::string kLive = "[[cue]]\nname = \"live\"\nsource = \"live\"\n";
std::string still(const std::string& name, const std::string& rest) {
  return "[[cue]]\nname = \"" + name +
         "\"\nsource = \"generated\"\nworld = \"bars\"\nface_size = [48, 48]\nduration_s = 0.5\n" + rest;
}

// Three cameras go and come back, one is slower.
TEST_F(Nv12Frames, AreTheSlowWarpsToTheByteWithoutACopyOrAnAllocation) {
  open(kLive, [](std::size_t c, FakeCameraDevice& device, CameraSetup&) {
    device.jitter = 1ms;
    if (c == 2) device.rate = 20.0;
  });
  int compared = 0;
  int bright = 0;
  const LoopCounts faulty = play(5s, [&](int flip, const DisplayBuffer& buffer) {
    for (const std::size_t c : {0U, 1U, 2U}) {
      if (flip == 60) cameras_->fakes[c]->begin_fault(CameraFault::kUnplugged);
      if (flip == 150) cameras_->fakes[c]->end_faults();
    }
    ASSERT_NE(buffer.chroma, nullptr) << flip;
    const Bytes bytes = seen(buffer);
    ASSERT_EQ(bytes, expected()) << flip;
    ++compared;
    bright += *std::max_element(bytes.begin(), bytes.end()) > 150 ? 1 : 0;
  });
  EXPECT_EQ(compared, 300);
  EXPECT_GT(bright, 290);
  EXPECT_FALSE(colour_.bt709);
  EXPECT_FALSE(colour_.full_range);
  const LoopCounts counts = play(5s);
  EXPECT_EQ(counts.frames_nv12, counts.frames_presented - counts.frames_unchanged);
  EXPECT_GT(counts.frames_nv12, 200);
  EXPECT_EQ(counts.heap_allocations, 0);
  EXPECT_EQ(counts.pixel_bytes_copied, 0);
  EXPECT_GT(faulty.tiles.skipped, 0) << "tiles of slates stand";
}

TEST_F(Nv12Frames, StandAmongFramesThatAreMixedOrOfOtherCues) {
  const std::string fade = "transition = \"fade\"\nfade_s = 0.2\n";
  open(still("one", "") + kLive + "duration_s = 0.5\n" + fade + still("three", fade));
  int nv12 = 0;
  int others = 0;
  play(10s, [&](int flip, const DisplayBuffer& buffer) {
    const bool plain = frames_->timeline().cue() == 1 && !frames_->timeline().fade();
    EXPECT_EQ(buffer.chroma != nullptr, plain) << flip;
    if (buffer.chroma) {
      EXPECT_EQ(seen(buffer), expected()) << flip;
    }
    ++(buffer.chroma ? nv12 : others);
  });
  EXPECT_EQ(nv12, 18);
  EXPECT_EQ(others, 72);
}

TEST_F(Nv12Frames, GiveWayToTheOperator) {
  open(kLive);
  PatternBoard board(
      {kWidth, kHeight},
      [](std::size_t, const MutableImage& into) {
        for (int y = 0; y < kHeight; ++y) std::fill_n(into.samples<std::uint32_t>(0, y), kWidth, 0xff123456U);
      },
      link_.log);
  link_.patterns = &board;
  Screenshots screenshots(
      {kWidth, kHeight}, [](const Screenshot&) { return std::string(); }, link_.log);
  link_.screenshots = &screenshots;
  std::array<int, 5> xrgb{};  // by what was wished
  std::size_t now = 0;
  const auto wish = [&](std::size_t number, const char* word, const char* argument) {
    now = number;
    link_.commands.push(parse_command(word, argument, {}));
  };
  const LoopCounts counts = play(10s, [&](int flip, const DisplayBuffer& buffer) {
    std::this_thread::sleep_for(1ms);  // for the threads beside the loop
    if (flip == 20) wish(1, "blackout", "on");
    if (flip == 50) wish(0, "blackout", "off");
    if (flip == 60) wish(2, "fade", "out 0.1");
    if (flip == 100) wish(0, "fade", "in 0");
    if (flip == 110) wish(3, "test-pattern", "alignment");
    if (flip == 400) wish(0, "test-pattern", "off");
    if (flip == 450) wish(4, "screenshot", "");
    if (buffer.chroma) {
      ASSERT_EQ(seen(buffer), expected()) << flip;
    } else {
      ++xrgb[now];
    }
  });
  EXPECT_NEAR(xrgb[1], 29, 1);
  EXPECT_NEAR(xrgb[2], 39, 1);
  EXPECT_GT(xrgb[3], 1);
  EXPECT_EQ(xrgb[4], 1);
  EXPECT_LE(xrgb[0], 6) << "two flips about each wish";
  EXPECT_EQ(counts.screenshots, 1);
}

TEST_F(Nv12Frames, AreXrgbWhereTheDisplayTakesNoOther) {
  open(kLive);
  able_ = false;
  const LoopCounts counts =
      play(1s, [&](int flip, const DisplayBuffer& buffer) { EXPECT_EQ(buffer.chroma, nullptr) << flip; });
  EXPECT_EQ(counts.frames_nv12, 0);
  EXPECT_GT(counts.frames_presented, 50);
  const std::vector<EventLog::Line> lines = link_.log.lines();
  EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [](const EventLog::Line& line) {
    return line.text == "the display takes no NV12: frames are XRGB8888";
  }));
}

// The page's picture is the screen's: converted by the control page's side, pixel for pixel.
TEST_F(Nv12Frames, AreSeenInThePreviewAsXrgbFramesAre) {
  std::array<ImageBuffer, 2> previews;
  for (const bool able : {false, true}) {
    able_ = able;
    open(kLive);
    Preview preview({kWidth, kHeight});
    link_.preview = &preview;
    ImageBuffer& into = previews[able ? 1 : 0];
    preview.newest(into);
    play(1s, [&](int, const DisplayBuffer&) { cameras_->fakes[0]->begin_fault(CameraFault::kSilent); });
    EXPECT_GT(preview.newest(into), 0);
    link_.preview = nullptr;
  }
  double sum = 0.0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto of = [&](std::size_t i) {
        return std::as_const(previews[i]).pixels().samples<std::uint32_t>(0, y)[x];
      };
      for (int shift = 0; shift < 24; shift += 8) {
        sum += std::abs(static_cast<int>(of(0) >> shift & 255U) - static_cast<int>(of(1) >> shift & 255U));
      }
    }
  }
  EXPECT_LT(sum / (3.0 * kWidth * kHeight), 6.0) << "half of the chroma, on pictures of 48 texels";
}

TEST(Nv12FramesRefused, WhereColoursWouldHaveToBeConverted) {
  const auto refusal = [](const LiveColours& colours, CameraFormat format) -> std::string {
    try {
      LiveShow([&](std::size_t, FakeCameraDevice& device,
                   CameraSetup& setup) { device.formats = setup.formats = {format}; },
               small_rig(), {}, colours, with_nv12());
    } catch (const Failure& failure) {
      return failure.what();
    }
    return {};
  };
  LiveColours locked;
  locked.locked[0] = ViewColour{};
  EXPECT_THAT(refusal(locked, CameraFormat::kNv12),
              HasSubstr("display.format: expected XRGB8888, as colours are matched or locked"));
  EXPECT_THAT(refusal({}, CameraFormat::kRgb24),
              HasSubstr("display.format: expected XRGB8888, as cameras send RGB3"));
  EXPECT_EQ(refusal({}, CameraFormat::kYuyv), "");
}

}  // namespace
}  // namespace cupola
