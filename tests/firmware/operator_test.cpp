// Commands down to the screen, on a fake clock: which frame each flip shows.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <functional>
#include <map>

#include "firmware/frame_loop.h"
#include "firmware/timeline.h"
#include "hal/display/fake_display.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr nanoseconds kPeriod = 10ms;

// A show of nothing: notes the moments of its timeline.
class NotedFrames final : public FrameMaker {
 public:
  explicit NotedFrames(std::vector<CueTiming> cues) : timeline_(std::move(cues)) { moments.reserve(4096); }
  Change advance(const Due& due) noexcept override {
    EXPECT_GE(due.time, time_) << "the show's time runs backwards";
    time_ = due.time;
    for (const PlayerCommand& command : due.commands) obey(timeline_, command, due.time);
    const std::optional<Moment> moment = timeline_.at(due.time);
    if (!moment) return Change::kOver;
    moments.push_back(*moment);
    return Change::kNew;
  }
  WarpWork warp(const MutableImage& /*frame*/, int /*age*/) noexcept override { return {1, 0}; }
  void shown(nanoseconds /*flipped_at*/) noexcept override {}
  double rate() const override { return 100.0; }
  void report(ShowReport& report) const noexcept override {
    report.cue = timeline_.cue();
    report.position = timeline_.position(time_);
    report.duration = timeline_.cue_length();
    report.waiting = timeline_.waiting();
  }

  std::vector<Moment> moments;  // one a flip

 private:
  Timeline timeline_;
  nanoseconds time_{0};
};

// Commands while flip number ... waits.
class CommandingDisplay final : public Display {
 public:
  CommandingDisplay(Clock& clock, CommandQueue& queue, std::multimap<int, PlayerCommand> commands)
      : display_(clock, 8, 8, kPeriod), queue_(queue), commands_(std::move(commands)) {}
  DisplayBuffer back_buffer() noexcept override { return display_.back_buffer(); }
  Presented present(nanoseconds when) noexcept override { return flip(display_.present(when)); }
  Presented repeat(nanoseconds when) noexcept override { return flip(display_.repeat(when)); }
  nanoseconds period() const noexcept override { return kPeriod; }
  const char* trouble() const noexcept override { return ""; }

 private:
  Presented flip(Presented presented) noexcept {
    const auto [first, last] = commands_.equal_range(flips_++);
    for (auto it = first; it != last; ++it) queue_.push(it->second);
    return presented;
  }
  FakeDisplay display_;
  CommandQueue& queue_;
  std::multimap<int, PlayerCommand> commands_;
  int flips_ = 0;
};

class OperatorTest : public testing::Test {
 protected:
  // Three cues of a second; the second one waits at its end.
  std::vector<Moment> play(std::multimap<int, PlayerCommand> commands, std::optional<nanoseconds> time = {}) {
    NotedFrames frames({{.rate = 100.0, .frames = 100, .then = 1},
                        {.rate = 100.0, .frames = 100, .then = 2, .wait = true},
                        {.rate = 100.0, .frames = 100}});
    CommandingDisplay display(clock_, link_.commands, std::move(commands));
    FrameLoop loop(frames, display, clock_, pool_, nullptr, &link_);
    loop.run(time);
    counts_ = loop.counts();
    return frames.moments;
  }
  FakeClock clock_;
  WorkerPool pool_{1};
  ControlLink link_;
  LoopCounts counts_;
};

PlayerCommand seek(nanoseconds position) {
  return {PlayerAction::kSeek, position};
}
PlayerCommand cue(std::size_t cue) {
  return {PlayerAction::kCue, 0ns, cue};
}

TEST_F(OperatorTest, AWaitEndsWithGo) {
  const std::vector<Moment> moments = play({{50, {PlayerAction::kGo}}, {249, {PlayerAction::kGo}}});
  ASSERT_EQ(moments.size(), 350U);
  for (std::int64_t i = 0; i < 350; ++i) {
    const Moment expected = i < 100   ? Moment{0, i}
                            : i < 200 ? Moment{1, i - 100}
                            : i < 250 ? Moment{1, 99}
                                      : Moment{2, i - 250};
    ASSERT_EQ(moments[static_cast<std::size_t>(i)], expected) << i;
  }
}

TEST_F(OperatorTest, NobodySaysGoAndTheLastPictureStands) {
  const std::vector<Moment> moments = play({}, 100s);
  EXPECT_EQ(moments.size(), 10'000U);
  EXPECT_EQ(moments.back(), (Moment{1, 99}));
}

TEST_F(OperatorTest, APauseHoldsEveryFrameAndPlayGoesOnWithTheNext) {
  const std::vector<Moment> moments =
      play({{29, {PlayerAction::kPause}}, {39, {PlayerAction::kPause}}, {79, {PlayerAction::kPlay}}}, 1s);
  for (std::int64_t i = 0; i < 100; ++i) {
    const std::int64_t frame = i < 30 ? i : i < 80 ? 29 : i - 50;
    ASSERT_EQ(moments[static_cast<std::size_t>(i)], (Moment{0, frame})) << i;
  }
}

TEST_F(OperatorTest, SeekCueAndPreviousTakeEffectAtTheNextFlip) {
  const std::vector<Moment> moments = play({{9, seek(800ms)},
                                            {14, seek(100ms)},
                                            {19, cue(2)},
                                            {24, {PlayerAction::kPrevious}},
                                            {29, {PlayerAction::kPrevious}}},
                                           350ms);
  const Moment starts[] = {{0, 0}, {0, 5}, {0, 80}, {0, 10}, {2, 0}, {1, 0}, {0, 0}};
  for (std::size_t i = 0; i < 35; ++i) {
    const Moment& start = starts[i / 5];
    ASSERT_EQ(moments[i], (Moment{start.cue, start.frame + static_cast<std::int64_t>(i % 5)})) << i;
  }
}

TEST_F(OperatorTest, SeeksInAPauseShowThePlaceAndStay) {
  const std::vector<Moment> moments =
      play({{9, {PlayerAction::kPause}}, {19, seek(500ms)}, {29, {PlayerAction::kPlay}}}, 400ms);
  for (std::int64_t i = 0; i < 40; ++i) {
    const std::int64_t frame = i < 10 ? i : i < 20 ? 9 : i < 30 ? 50 : i + 21;
    ASSERT_EQ(moments[static_cast<std::size_t>(i)], (Moment{0, frame})) << i;
  }
}

TEST_F(OperatorTest, CommandsOfOneFrameAreObeyedInTheirOrder) {
  const std::vector<Moment> moments =
      play({{4, cue(2)}, {4, seek(300ms)}, {4, {PlayerAction::kPrevious}}}, 60ms);
  EXPECT_EQ(moments.back(), (Moment{1, 0}));
  const std::vector<Moment> other =
      play({{4, {PlayerAction::kPrevious}}, {4, cue(2)}, {4, seek(300ms)}}, 60ms);
  EXPECT_EQ(other.back(), (Moment{2, 30}));
}

TEST_F(OperatorTest, ABlackoutLastsUntilItIsTakenBack) {
  play({{9, {PlayerAction::kBlackout}},
        {19, {PlayerAction::kBlackoutOff}},
        {29, {PlayerAction::kBlackoutToggle}},
        {34, {PlayerAction::kBlackoutToggle}}},
       1s);
  EXPECT_EQ(counts_.blackout_frames, 15);
  EXPECT_EQ(counts_.frames_presented, 100);
}

// Light of each flip.
class LightTest : public testing::Test {
 protected:
  double obey(int milliseconds) {
    wishes_.obey(queue_, milliseconds * 1ms);
    return static_cast<double>(wishes_.light()) / kWholeWeight;
  }
  CommandQueue queue_;
  OperatorWishes wishes_;
};

TEST_F(LightTest, GoesToBlackAndBackInTheTimeGiven) {
  EXPECT_EQ(obey(1000), 1.0);
  queue_.push({PlayerAction::kFade, 2s});
  EXPECT_EQ(obey(1010), 1.0);
  EXPECT_NEAR(obey(1510), 0.75, 1e-4);
  EXPECT_NEAR(obey(2010), 0.5, 1e-4);
  EXPECT_FALSE(wishes_.black());
  EXPECT_EQ(obey(3010), 0.0);
  EXPECT_TRUE(wishes_.black());
  EXPECT_EQ(obey(9000), 0.0);
  queue_.push({PlayerAction::kFade, 1s});
  obey(9010);
  EXPECT_NEAR(obey(9260), 0.25, 1e-4);
  EXPECT_EQ(obey(10'100), 1.0);
}

TEST_F(LightTest, TurnsRoundFromWhereItIs) {
  obey(0);
  queue_.push({PlayerAction::kFadeOut, 1s});
  obey(10);
  EXPECT_NEAR(obey(310), 0.7, 1e-4);
  queue_.push({PlayerAction::kFade, 2s});
  EXPECT_NEAR(obey(410), 0.6, 1e-4);
  EXPECT_NEAR(obey(810), 0.8, 1e-4);
  queue_.push({PlayerAction::kFadeOut, 0s});
  obey(820);
  EXPECT_EQ(obey(830), 0.0);
}

TEST_F(LightTest, IsTakenBackByBlackoutOffAndOutOfABlackoutComesByAFade) {
  obey(0);
  queue_.push({PlayerAction::kFadeOut, 0s});
  obey(10);
  EXPECT_EQ(obey(20), 0.0);
  queue_.push({PlayerAction::kBlackoutToggle});
  EXPECT_EQ(obey(30), 1.0);
  queue_.push({PlayerAction::kBlackout});
  obey(40);
  EXPECT_TRUE(wishes_.black());
  queue_.push({PlayerAction::kFade, 1s});
  EXPECT_EQ(obey(50), 0.0);
  EXPECT_NEAR(obey(550), 0.5, 1e-4);
  EXPECT_FALSE(wishes_.black());
}

TEST_F(OperatorTest, AFadeGoesThroughBlackWithoutAllocatingOrBeingLate) {
  play({{9, {PlayerAction::kFadeOut, 200ms}}, {49, {PlayerAction::kFadeIn, 200ms}}}, 1s);
  // Out: flips 10 to 30, the last of them black, as are those to 50; in from 51.
  EXPECT_EQ(counts_.blackout_frames, 21);
  EXPECT_EQ(counts_.heap_allocations, 0);
  EXPECT_EQ(counts_.frames_late, 0);
}

TEST_F(OperatorTest, AFloodOfCommandsNeitherStopsNorAllocates) {
  std::multimap<int, PlayerCommand> flood;
  for (int flip = 0; flip < 200; ++flip) {
    for (int i = 0; i < 100; ++i)
      flood.insert({flip, {i % 2 ? PlayerAction::kBlackout : PlayerAction::kSeek}});
  }
  EXPECT_EQ(play(std::move(flood), 2s).size(), 200U);
  EXPECT_EQ(counts_.frames_late, 0);
  EXPECT_EQ(counts_.heap_allocations, 0);
}

}  // namespace
}  // namespace cupola
