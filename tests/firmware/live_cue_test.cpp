// Live cues among others: every frame is the cue's, from its first one on, and the cameras never rest.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstring>

#include "firmware/control_link.h"
#include "firmware/frame_mix.h"
#include "firmware/show_frames.h"
#include "pipeline/frame/error.h"
#include "tests/firmware/live_show.h"
#include "tests/frame/temporary_folder.h"

namespace cupola {
namespace {

using namespace test;

constexpr nanoseconds kPeriod = 16'666'667ns;
const std::string kHalf = "duration_s = 0.5\n";
const std::string kFade = "transition = \"fade\"\nfade_s = 0.2\n";

std::string still(const std::string& name, const std::string& rest) {
  return "[[cue]]\nname = \"" + name +
         "\"\nsource = \"generated\"\nworld = \"bars\"\nface_size = [48, 48]\n" + rest;
}
std::string live(const std::string& name, const std::string& rest) {
  return "[[cue]]\nname = \"" + name + "\"\nsource = \"live\"\n" + rest;
}

ImageBuffer copy_of(const DisplayBuffer& buffer) {
  ImageBuffer copy(PixelFormat::kXrgb8888, {buffer.width, buffer.height});
  for (int y = 0; y < buffer.height; ++y) {
    std::memcpy(copy.pixels().samples<std::uint32_t>(0, y), buffer.data + y * buffer.stride,
                std::size_t{4} * static_cast<std::size_t>(buffer.width));
  }
  return copy;
}

// The unused byte of a pixel is not looked at.
int pixels_apart(const ImageBuffer& a, const ImageBuffer& b) {
  int apart = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto of = [&](const ImageBuffer& frame) {
        return frame.pixels().samples<const std::uint32_t>(0, y)[x] & 0xffffffU;
      };
      apart += of(a) != of(b) ? 1 : 0;
    }
  }
  return apart;
}

class LiveCue : public testing::Test {
 protected:
  void open(const std::string& cues,
            const std::function<void(std::size_t, FakeCameraDevice&, CameraSetup&)>& adjust = {}) {
    cameras_ = std::make_unique<LiveShow>(adjust);
    live_ = cameras_->frames.get();
    frames_ = std::make_unique<ShowFrames>(show_of(cues), Method::kEwa, best_cpu(), cameras_->pool, false,
                                           nullptr, Decoding::kInTurn, std::move(cameras_->frames));
    Rig rig = live_->rig();
    reference_ = make_native_to_xrgb_warp(rig, NativeLayout::kNv12, Cpu::kScalar, cameras_->pool);
    ShowFrames stands(show_of(still("one", kHalf)), Method::kEwa, Cpu::kScalar, cameras_->pool);
    stands.advance({});
    stands.warp(still_.pixels(), 0);
  }

  Show show_of(const std::string& cues) {
    const std::string lines[] = {"rig.frame.width=64", "rig.frame.height=48", "rig.frame.center=[32, 24]",
                                 "rig.frame.radius=30"};
    write_text(folder_ / "show.toml", "rig = \"omnimax\"\n\n" + cues);
    return load_show(folder_ / "show.toml", lines);
  }

  // Calls `see` after every flip with its number and what is on the screen.
  LoopCounts play(nanoseconds time, const std::function<void(int, ImageBuffer)>& see = {}) {
    SeenDisplay display(cameras_->clock, {kWidth, kHeight}, [&](int flip, const DisplayBuffer& buffer) {
      if (see) see(flip, copy_of(buffer));
    });
    FrameLoop loop(*frames_, display, cameras_->clock, cameras_->pool, nullptr, &link_);
    loop.run(time);
    return loop.counts();
  }

  // All of the cameras' pictures as they are now, by the slow kernel.
  ImageBuffer live_frame() {
    ImageBuffer frame(PixelFormat::kXrgb8888, {kWidth, kHeight});
    reference_->warp(live_->faces().faces(), frame.pixels());
    return frame;
  }
  ImageBuffer mixed(const ImageBuffer& a, const ImageBuffer& b, std::int32_t weight) {
    ImageBuffer frame(PixelFormat::kXrgb8888, {kWidth, kHeight});
    mix(a.pixels(), b.pixels(), weight, frame.pixels(), cameras_->pool);
    return frame;
  }
  std::size_t cue() const { return frames_->timeline().cue(); }
  nanoseconds age() const { return cameras_->clock.now() - live_->faces().sync().captured_at(); }

  TemporaryFolder folder_;
  ControlLink link_;
  std::unique_ptr<LiveShow> cameras_;
  LiveFrames* live_ = nullptr;
  std::unique_ptr<ShowFrames> frames_;
  std::unique_ptr<NativeWarp<MutableImage>> reference_;
  ImageBuffer still_{PixelFormat::kXrgb8888, {kWidth, kHeight}};
};

TEST_F(LiveCue, IsSeenFromItsFirstFlipToItsLastAndNowhereElse) {
  open(still("one", kHalf) + live("two", kHalf) + still("three", kHalf) + live("four", kHalf));
  int lives = 0;
  int stills = 0;
  std::vector<nanoseconds> ages;
  play(10s, [&](int flip, const ImageBuffer& frame) {
    if (cue() % 2 == 0) {
      ++stills;
      EXPECT_EQ(pixels_apart(frame, still_), 0) << flip;
      return;
    }
    ++lives;
    ages.push_back(age());
    EXPECT_EQ(pixels_apart(frame, live_frame()), 0) << flip;
  });
  EXPECT_EQ(stills, 60);
  ASSERT_EQ(lives, 60);
  for (const std::size_t first : {0U, 30U}) EXPECT_LE(ages[first], kPeriod + 12ms) << "no old picture first";
  EXPECT_GT(live_->latencies_ms().size(), 50U);
}

TEST_F(LiveCue, TakesNothingFromTheHeapAndCopiesNoPicture) {
  open(still("one", kHalf) + live("two", kHalf + kFade) + still("three", kHalf + kFade + "then = \"two\"\n"));
  const LoopCounts counts = play(20s);
  EXPECT_EQ(counts.heap_allocations, 0);
  EXPECT_EQ(counts.frames_failed, 0);
  EXPECT_EQ(live_->pixel_bytes_copied(), 0);
}

TEST_F(LiveCue, FadesInAndOutWhileItMoves) {
  open(still("one", kHalf) + live("two", kHalf + kFade) + still("three", kHalf + kFade));
  int mixed_frames = 0;
  std::uint64_t sets = 0;
  play(10s, [&](int flip, const ImageBuffer& frame) {
    const std::optional<Fade>& fade = frames_->timeline().fade();
    if (!fade || !fade->from) return;
    const bool comes = cue() == 1;
    const ImageBuffer now = live_frame();
    EXPECT_EQ(
        pixels_apart(frame, comes ? mixed(still_, now, fade->weight) : mixed(now, still_, fade->weight)), 0)
        << flip;
    if (mixed_frames++ == 0) sets = live_->faces().sync().counts().sets;
  });
  EXPECT_EQ(mixed_frames, 24);
  EXPECT_GT(live_->faces().sync().counts().sets, sets + 20);
}

TEST_F(LiveCue, IsMixedFromWhatAFadeShowedThatIsCutShort) {
  open(still("one", "duration_s = 0.1\n") + live("two", kFade) + still("three", kHalf + kFade));
  ImageBuffer last;
  int after = 0;
  play(1s, [&](int flip, ImageBuffer frame) {
    const std::optional<Fade>& fade = frames_->timeline().fade();
    if (cue() == 1) {
      if (fade && fade->weight > kWholeWeight / 2) link_.commands.push({PlayerAction::kNext});
      last = std::move(frame);
    }
    if (cue() == 2 && fade) {
      ++after;
      EXPECT_EQ(pixels_apart(frame, mixed(last, still_, fade->weight)), 0) << flip;
    }
  });
  EXPECT_EQ(after, 12);
}

TEST_F(LiveCue, GoesOnWhereTheShowIsPausedOrWaits) {
  open(live("one", kHalf + "then = \"wait\"\n") + still("two", kHalf));
  link_.commands.push({PlayerAction::kPause});
  std::uint64_t sets = 0;
  play(2s, [&](int flip, const ImageBuffer& frame) {
    ShowReport report;
    frames_->report(report);
    EXPECT_EQ(cue(), 0U);
    EXPECT_EQ(pixels_apart(frame, live_frame()), 0) << flip;
    if (flip == 20) {
      EXPECT_EQ(report.position, 0s);
      link_.commands.push({PlayerAction::kPlay});
    }
    if (flip == 80) {
      EXPECT_TRUE(report.waiting);
      sets = live_->faces().sync().counts().sets;
    }
  });
  EXPECT_GT(live_->faces().sync().counts().sets, sets + 30);
}

// Nobody looks, and yet it is noticed and mended.
TEST_F(LiveCue, LosesAndFindsACameraUnseen) {
  open(still("one", "duration_s = 2\n") + live("two", kHalf));
  play(10s, [&](int flip, const ImageBuffer& frame) {
    if (flip == 20) cameras_->fakes[1]->begin_fault(CameraFault::kUnplugged);
    if (flip == 70) {
      EXPECT_EQ(live_->faces().sync().faces()[1].state, SyncedFace::State::kSlate);
    }
    if (flip == 80) cameras_->fakes[1]->end_faults();
    if (cue() == 0) return;
    EXPECT_EQ(live_->faces().sync().faces()[1].state, SyncedFace::State::kInStep) << flip;
    EXPECT_EQ(pixels_apart(frame, live_frame()), 0) << flip;
  });
  EXPECT_EQ(live_->cameras()[1].watch->counts().losses, 1U);
}

TEST_F(LiveCue, NeedsCameras) {
  WorkerPool pool(1);
  try {
    ShowFrames(show_of(still("one", kHalf) + live("two", kHalf)), Method::kEwa, Cpu::kScalar, pool);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "cue two: live can only be played");
  }
}

}  // namespace
}  // namespace cupola
