// The frame loop under a fake clock: pacing, late frames, dropped ones, and how it ends.
// SPDX-License-Identifier: MIT
#include "firmware/frame_loop.h"

#include <gtest/gtest.h>

#include <cstring>

#include "firmware/show_frames.h"
#include "hal/display/fake_display.h"
#include "tests/firmware/said.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

// A small rig and one generated cue of two seconds at 60 Hz.
class FrameLoopTest : public testing::Test {
 protected:
  static Show small_demo() {
    const std::string lines[] = {"rig.frame.width=64",        "rig.frame.height=48",
                                 "rig.frame.center=[32, 24]", "rig.frame.radius=30",
                                 "cue.0.face_size=[32, 32]",  "cue.0.duration_s=2"};
    return load_show("demo", lines);
  }
  FrameLoopTest() { frames_ = std::make_unique<ShowFrames>(small_demo(), Method::kEwa, Cpu::kScalar, pool_); }
  WorkerPool pool_{2};
  FakeClock clock_;
  std::unique_ptr<ShowFrames> frames_;
};

// Takes `extra` longer for the frames in [first, last): a machine that is too slow for a while.
class SlowDisplay final : public Display {
 public:
  SlowDisplay(FakeClock& clock, Display& display, int first, int last, nanoseconds extra)
      : clock_(clock), display_(display), first_(first), last_(last), extra_(extra) {}
  DisplayBuffer back_buffer() noexcept override { return display_.back_buffer(); }
  Presented present(nanoseconds when) noexcept override {
    const int frame = frame_++;
    if (frame >= first_ && frame < last_) clock_.advance(extra_);
    return display_.present(when);
  }
  Presented repeat(nanoseconds when) noexcept override { return display_.repeat(when); }
  nanoseconds period() const noexcept override { return display_.period(); }
  const char* trouble() const noexcept override { return display_.trouble(); }

 private:
  FakeClock& clock_;
  Display& display_;
  int first_;
  int last_;
  nanoseconds extra_;
  int frame_ = 0;
};

TEST_F(FrameLoopTest, PresentsAFrameAFlip) {
  FakeDisplay display(clock_, 64, 48);
  FrameLoop loop(*frames_, display, clock_, pool_);
  EXPECT_EQ(loop.run({}), LoopEnd::kOver);
  EXPECT_EQ(loop.counts().frames_presented, 120);
  EXPECT_EQ(loop.counts().frames_late, 0);
  EXPECT_EQ(loop.counts().frames_dropped, 0);
  EXPECT_EQ(loop.counts().heap_allocations, 0);
  EXPECT_EQ(loop.warp_ms().size(), 120U);
  EXPECT_EQ(display.frames(), 120);
}

// Compares every frame with the same frame made whole, by `frames` at 60 a second.
class CheckingDisplay final : public Display {
 public:
  CheckingDisplay(FakeDisplay& display, ShowFrames& frames) : display_(display), frames_(frames) {}
  DisplayBuffer back_buffer() noexcept override { return display_.back_buffer(); }
  Presented present(nanoseconds when) noexcept override {
    const Presented presented = display_.present(when);
    ImageBuffer whole(PixelFormat::kXrgb8888, frames_.frame_size());
    const nanoseconds time = nanoseconds(1s) * count_++ / 60;
    frames_.advance({time, time});
    frames_.warp(whole.pixels(), 0);
    const DisplayBuffer shown = display_.front_buffer();
    for (int y = 0; y < shown.height; ++y) {
      equal_ = equal_ && std::memcmp(shown.data + y * shown.stride, whole.pixels().planes[0].row(y),
                                     std::size_t{4} * static_cast<std::size_t>(shown.width)) == 0;
    }
    return presented;
  }
  Presented repeat(nanoseconds when) noexcept override { return display_.repeat(when); }
  nanoseconds period() const noexcept override { return display_.period(); }
  const char* trouble() const noexcept override { return display_.trouble(); }
  bool equal() const { return equal_; }

 private:
  FakeDisplay& display_;
  ShowFrames& frames_;
  int count_ = 0;
  bool equal_ = true;
};

TEST_F(FrameLoopTest, WarpsOnlyTilesInWhichSomethingMoved) {
  const std::string lines[] = {"rig.frame.width=300",         "rig.frame.height=220",
                               "rig.frame.center=[150, 150]", "rig.frame.radius=150",
                               "cue.0.face_size=[256, 256]",  "cue.0.duration_s=1"};
  ShowFrames frames(load_show("demo", lines), Method::kEwa, best_cpu(), pool_);
  ShowFrames whole(load_show("demo", lines), Method::kEwa, best_cpu(), pool_);
  FakeDisplay fake(clock_, 300, 220);
  CheckingDisplay display(fake, whole);
  FrameLoop loop(frames, display, clock_, pool_);
  EXPECT_EQ(loop.run({}), LoopEnd::kOver);
  EXPECT_EQ(loop.counts().frames_presented, 60);
  EXPECT_GT(loop.counts().tiles.skipped, loop.counts().tiles.pieces / 10);
  EXPECT_TRUE(display.equal());
}

TEST_F(FrameLoopTest, GoesOnWithTheShowsTimeWhenItFallsBehind) {
  FakeDisplay fake(clock_, 64, 48);
  SlowDisplay display(clock_, fake, 10, 20, 40ms);  // each of ten frames misses two flips
  FrameLoop loop(*frames_, display, clock_, pool_);
  EXPECT_EQ(loop.run({}), LoopEnd::kOver);
  EXPECT_EQ(loop.counts().frames_dropped, 20);
  EXPECT_EQ(loop.counts().frames_late, 10);
  EXPECT_EQ(loop.counts().frames_presented, 100);
  EXPECT_NEAR(std::chrono::duration<double>(clock_.now()).count(), 2.0, 0.02)
      << "the show is no longer for it";
}

TEST_F(FrameLoopTest, StopsWhenItsTimeIsUp) {
  FakeDisplay display(clock_, 64, 48);
  FrameLoop loop(*frames_, display, clock_, pool_);
  EXPECT_EQ(loop.run(500ms), LoopEnd::kTimeUp);
  EXPECT_EQ(loop.counts().frames_presented, 30);
}

TEST_F(FrameLoopTest, StopsWhenTheDisplayIsClosedOrLost) {
  FakeDisplay closed(clock_, 64, 48);
  closed.close();
  EXPECT_EQ(FrameLoop(*frames_, closed, clock_, pool_).run({}), LoopEnd::kClosed);
  FakeDisplay lost(clock_, 64, 48);
  lost.lose();
  EXPECT_EQ(FrameLoop(*frames_, lost, clock_, pool_).run({}), LoopEnd::kLost);
}

TEST_F(FrameLoopTest, GoesOnWithoutItsDisplayUntilThatIsBack) {
  FakeDisplay fake(clock_, 64, 48);
  fake.set_absences({{500ms, 1s}, {1500ms, 1530ms}});
  ShowFrames whole(small_demo(), Method::kEwa, Cpu::kScalar, pool_);
  CheckingDisplay display(fake, whole);
  ControlLink link;
  FrameLoop loop(*frames_, display, clock_, pool_, nullptr, &link);
  EXPECT_EQ(loop.run({}), LoopEnd::kOver);
  EXPECT_EQ(said(link.log),
            "cupola: the display is away: unplugged on demand\ncupola: the display is back\n"
            "cupola: the display is away: unplugged on demand\ncupola: the display is back\n");
  EXPECT_EQ(loop.counts().display_losses, 2);
  EXPECT_EQ(loop.counts().frames_unshown, 31);
  EXPECT_EQ(loop.counts().frames_presented, 89);
  EXPECT_EQ(loop.counts().frames_late, 0);
  EXPECT_EQ(loop.counts().frames_dropped, 0);
  EXPECT_TRUE(display.equal()) << "the frames after it are whole, though some before were not seen";
  EXPECT_NEAR(std::chrono::duration<double>(clock_.now()).count(), 2.0, 0.02);
}

TEST_F(FrameLoopTest, KeepsThePaceOfTheScreenThatComesBack) {
  FakeDisplay display(clock_, 64, 48);
  display.set_absences({{990ms, 1s, 20ms}});
  FrameLoop loop(*frames_, display, clock_, pool_);
  EXPECT_EQ(loop.run({}), LoopEnd::kOver);
  EXPECT_EQ(loop.counts().frames_unshown, 1);
  EXPECT_EQ(loop.counts().heap_allocations, 0);
  EXPECT_GE(loop.counts().frames_presented, 59 + 49);
  EXPECT_LE(loop.counts().frames_presented, 59 + 50);
  EXPECT_EQ(loop.counts().frames_late, 0);
  EXPECT_EQ(loop.counts().frames_dropped, 0);
}

TEST_F(FrameLoopTest, ShowsEveryFrameTwiceOnADisplayTwiceAsFast) {
  FakeDisplay display(clock_, 64, 48, nanoseconds(1s) / 120);
  FrameLoop loop(*frames_, display, clock_, pool_);
  EXPECT_EQ(loop.run({}), LoopEnd::kOver);
  EXPECT_EQ(loop.counts().frames_presented, 240);
  EXPECT_EQ(loop.counts().frames_unchanged, 120);
}

}  // namespace
}  // namespace cupola
