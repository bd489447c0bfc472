// The operator's buttons and lamps, down to the screen: fake lines, a fake display, a fake clock.
// SPDX-License-Identifier: MIT
#include "firmware/control_panel.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>

#include <gtest/gtest.h>

#include "firmware/frame_loop.h"
#include "firmware/show_frames.h"
#include "hal/display/fake_display.h"
#include "hal/gpio/fake_gpio.h"
#include "pipeline/frame/image.h"
#include "tests/firmware/said.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr nanoseconds kPeriod = 10ms;

// Notes what every flip showed, at which time, and whether it is right.
class Screen final : public Display {
 public:
  struct Flip {
    nanoseconds at;
    bool black;
    std::uint64_t hash;
  };
  explicit Screen(Clock& clock) : display_(clock, 64, 48, kPeriod) { flips_.reserve(4096); }
  DisplayBuffer back_buffer() noexcept override { return display_.back_buffer(); }
  Presented present(nanoseconds when) noexcept override { return note(display_.present(when)); }
  Presented repeat(nanoseconds when) noexcept override { return note(display_.repeat(when)); }
  nanoseconds period() const noexcept override { return display_.period(); }
  const char* trouble() const noexcept override { return display_.trouble(); }
  const std::vector<Flip>& flips() const { return flips_; }
  // The first flip at or after `time`.
  const Flip& at(nanoseconds time) const {
    return *std::find_if(flips_.begin(), flips_.end(), [&](const Flip& flip) { return flip.at >= time; });
  }

 private:
  Presented note(Presented presented) noexcept {
    const DisplayBuffer front = display_.front_buffer();
    bool black = true;
    for (int y = 0; y < 48; ++y) {
      const auto* row = reinterpret_cast<const std::uint32_t*>(front.data + y * front.stride);
      black = black && std::all_of(row, row + 64, [](std::uint32_t word) { return word == 0xff000000U; });
    }
    flips_.push_back({presented.flipped_at, black, display_.front_hash()});
    return presented;
  }

  FakeDisplay display_;
  std::vector<Flip> flips_;
};

PanelInput input(const char* name, std::optional<PlayerCommand> press) {
  PanelInput input{press, {}};
  input.line.name = name;
  input.line.debounce = 5ms;
  if (press) {
    input.line.edges = GpioEdges::kToActive;
  } else {
    input.line.debounce_kind = GpioDebounce::kAtOnce;
  }
  return input;
}

PanelOutput output(const char* name, OutputIs is) {
  PanelOutput output{is, {}};
  output.line.name = name;
  output.line.output = true;
  return output;
}

const GpioSettings kSettings = {
    {input("play", PlayerCommand{PlayerAction::kPlayPause}),
     input("next", PlayerCommand{PlayerAction::kNext}), input("dark", std::nullopt),
     input("go", PlayerCommand{PlayerAction::kGo}), input("back", PlayerCommand{PlayerAction::kPrevious}),
     input("fade", parse_command("fade", "0.5", {})), input("less", parse_command("volume", "-5", {})),
     input("third", PlayerCommand{.action = PlayerAction::kCue, .cue = 2}),
     input("ninth", PlayerCommand{.action = PlayerAction::kCue, .cue = 8})},
    {output("lamp", OutputIs::kLamp), output("shutter", OutputIs::kShutter),
     output("trigger", OutputIs::kCameraTrigger), output("tally", OutputIs::kTally)}};

// Three generated cues of one second each at 100 Hz. The first flip is at 10 ms, which is the show's time 0.
class ControlPanelTest : public testing::Test {
 protected:
  ControlPanelTest() {
    const std::string lines[] = {
        "rig.frame.width=64", "rig.frame.height=48", "rig.frame.center=[32, 24]", "rig.frame.radius=30",
        R"(cue=[{name="a", source="generated", world="demo", face_size=[32, 32], rate=100, duration_s=1},)"
        R"({name="b", source="generated", world="tree", face_size=[32, 32], rate=100, duration_s=1},)"
        R"({name="c", source="generated", world="demo", face_size=[32, 32], rate=100, duration_s=1}])"};
    show_ = load_show("demo", lines);
  }

  // Plays with a panel; `twin_` has played the same without one.
  LoopEnd play(std::optional<nanoseconds> time = {}) {
    frames_ = std::make_unique<ShowFrames>(show_, Method::kEwa, Cpu::kScalar, pool_);
    panel_ = std::make_unique<ControlPanel>(kSettings, gpio_, clock_, log_);
    loop_ = std::make_unique<FrameLoop>(*frames_, screen_, clock_, pool_, panel_.get());
    return loop_->run(time);
  }
  // What the show looks like at each of its frames, without a panel.
  std::vector<std::uint64_t> undisturbed() {
    FakeClock clock;
    Screen screen(clock);
    ShowFrames frames(show_, Method::kEwa, Cpu::kScalar, pool_);
    FrameLoop(frames, screen, clock, pool_).run({});
    std::vector<std::uint64_t> hashes;
    for (const Screen::Flip& flip : screen.flips()) hashes.push_back(flip.hash);
    return hashes;
  }
  int writes(std::string_view line, bool high, nanoseconds from, nanoseconds to) const {
    return static_cast<int>(std::count_if(gpio_.writes().begin(), gpio_.writes().end(), [&](const auto& w) {
      return w.line == line && w.high == high && w.at >= from && w.at < to;
    }));
  }

  WorkerPool pool_{2};
  FakeClock clock_;
  FakeGpio gpio_{clock_,
                 {{"panel",
                   {"play", "next", "dark", "go", "back", "fade", "less", "third", "ninth", "lamp", "shutter",
                    "trigger", "tally"}}}};
  Screen screen_{clock_};
  EventLog log_;
  Show show_;
  std::unique_ptr<ShowFrames> frames_;
  std::unique_ptr<ControlPanel> panel_;
  std::unique_ptr<FrameLoop> loop_;
};

TEST_F(ControlPanelTest, ABlackoutReachesTheScreenOnTheNextFrame) {
  gpio_.pull("dark", true, 503ms);  // while the frame of 510 ms waits for its flip
  gpio_.pull("dark", false, 804ms);
  EXPECT_EQ(play(), LoopEnd::kOver);
  for (const Screen::Flip& flip : screen_.flips()) {
    ASSERT_EQ(flip.black, flip.at >= 520ms && flip.at < 820ms) << flip.at.count();
  }
  EXPECT_EQ(loop_->counts().blackout_frames, 30);
  EXPECT_EQ(loop_->counts().frames_presented, 300);
  EXPECT_EQ(loop_->counts().heap_allocations, 0);
}

TEST_F(ControlPanelTest, TheShowGoesOnInTheDarkAndComesBackWhole) {
  for (int i = 0; i < 20; ++i) {  // dark for one frame, two, three, ...
    gpio_.pull("dark", true, i * 120ms + 105ms);
    gpio_.pull("dark", false, i * 120ms + 105ms + i % 4 * 10ms + 6ms);
  }
  EXPECT_EQ(play(), LoopEnd::kOver);
  const std::vector<std::uint64_t> expected = undisturbed();
  ASSERT_EQ(screen_.flips().size(), expected.size());
  int black = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    black += screen_.flips()[i].black ? 1 : 0;
    if (screen_.flips()[i].black) continue;
    ASSERT_EQ(screen_.flips()[i].hash, expected[i]) << i;
  }
  EXPECT_EQ(black, loop_->counts().blackout_frames);
  EXPECT_GE(black, 30);
}

TEST_F(ControlPanelTest, EvenATapDarkensAFrame) {
  gpio_.pull("dark", true, 502ms);
  gpio_.pull("dark", false, 508ms);
  play();
  EXPECT_TRUE(screen_.at(520ms).black);
  EXPECT_FALSE(screen_.at(530ms).black);
}

TEST_F(ControlPanelTest, ABouncingBlackoutIsOneBlackout) {
  gpio_.bounce("dark", true, 503ms, 21, 200us);
  gpio_.bounce("dark", false, 703ms, 21, 200us);
  play();
  int changes = 0;
  for (std::size_t i = 1; i < screen_.flips().size(); ++i) {
    changes += screen_.flips()[i].black != screen_.flips()[i - 1].black ? 1 : 0;
  }
  EXPECT_EQ(changes, 2);
  EXPECT_EQ(loop_->counts().blackout_frames, 20);
}

TEST_F(ControlPanelTest, StartsDarkWhenBlackoutIsOnAlready) {
  gpio_.pull("dark", true, 0ms);
  gpio_.pull("dark", false, 55ms);
  play();
  EXPECT_TRUE(screen_.flips()[0].black);
  EXPECT_TRUE(screen_.at(60ms).black);
  EXPECT_FALSE(screen_.at(70ms).black);
  EXPECT_EQ(screen_.at(70ms).hash, undisturbed()[6]);
}

TEST_F(ControlPanelTest, PlayPauseHoldsTheShowsTime) {
  gpio_.bounce("play", true, 403ms, 3, 1ms);
  gpio_.pull("play", false, 450ms);
  gpio_.pull("play", true, 903ms);
  EXPECT_EQ(play(), LoopEnd::kOver);
  EXPECT_EQ(screen_.flips().size(), 350U) << "half a second longer";
  const std::vector<std::uint64_t> expected = undisturbed();
  for (std::size_t i = 0; i < screen_.flips().size(); ++i) {
    const std::size_t frame = i < 40 ? i : i < 90 ? 40 : i - 50;
    ASSERT_EQ(screen_.flips()[i].hash, expected[frame]) << i;
  }
  EXPECT_EQ(loop_->counts().frames_dropped, 0);
  EXPECT_EQ(loop_->counts().frames_late, 0);
}

TEST_F(ControlPanelTest, NextGoesToTheNextCueFromItsStart) {
  gpio_.pull("next", true, 403ms);
  gpio_.pull("next", false, 450ms);
  gpio_.pull("next", true, 703ms);
  gpio_.pull("next", false, 750ms);
  gpio_.pull("next", true, 903ms);  // nothing follows the last cue
  EXPECT_EQ(play(), LoopEnd::kOver);
  const std::vector<std::uint64_t> expected = undisturbed();
  ASSERT_EQ(screen_.flips().size(), 171U);
  // The press at 403 ms is certain at 408 ms, after frame 40 was made.
  for (std::size_t i = 0; i < 171; ++i) {
    ASSERT_EQ(screen_.flips()[i].hash, expected[i < 41 ? i : i < 71 ? 59 + i : 129 + i]) << i;
  }
}

TEST_F(ControlPanelTest, GoEndsAPauseAndPreviousBeginsTheCueBeforeAgain) {
  gpio_.pull("play", true, 403ms);
  gpio_.pull("go", true, 603ms);
  gpio_.pull("back", true, 803ms);
  EXPECT_EQ(play(), LoopEnd::kOver);
  const std::vector<std::uint64_t> expected = undisturbed();
  ASSERT_EQ(screen_.flips().size(), 381U);
  for (std::size_t i = 0; i < 381; ++i) {
    ASSERT_EQ(screen_.flips()[i].hash, expected[i < 41 ? i : i < 61 ? 40 : i < 81 ? i - 20 : i - 81]) << i;
  }
}

TEST_F(ControlPanelTest, FadeGoesToBlackAndBackWithTheNextPress) {
  gpio_.bounce("fade", true, 503ms, 3, 1ms);  // certain at 508 ms or so: dark from 520 ms to 1020 ms
  gpio_.pull("fade", false, 600ms);
  gpio_.pull("fade", true, 1503ms);
  EXPECT_EQ(play(), LoopEnd::kOver);
  const std::vector<std::uint64_t> expected = undisturbed();
  ASSERT_EQ(screen_.flips().size(), expected.size()) << "the show's time goes on";
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Screen::Flip& flip = screen_.flips()[i];
    const bool whole = flip.at <= 520ms || flip.at >= 2040ms;
    const bool changing = (flip.at >= 550ms && flip.at <= 980ms) || (flip.at >= 1570ms && flip.at <= 1980ms);
    const bool dark = flip.at >= 1040ms && flip.at <= 1510ms;
    const bool other = flip.hash != expected[i];
    ASSERT_TRUE(!whole || !other) << i;
    ASSERT_TRUE(!changing || (other && !flip.black)) << i;
    ASSERT_TRUE(!dark || flip.black) << i;
  }
  EXPECT_EQ(loop_->counts().heap_allocations, 0);
}

TEST_F(ControlPanelTest, AButtonOfACueBeginsItWhereTheShowHasIt) {
  gpio_.pull("ninth", true, 203ms);  // three cues
  gpio_.pull("third", true, 403ms);
  EXPECT_EQ(play(), LoopEnd::kOver);
  const std::vector<std::uint64_t> expected = undisturbed();
  ASSERT_EQ(screen_.flips().size(), 141U);
  for (std::size_t i = 0; i < 141; ++i) {
    ASSERT_EQ(screen_.flips()[i].hash, expected[i < 41 ? i : 159 + i]) << i;
  }
}

TEST_F(ControlPanelTest, EveryPressIsItsCommandOnce) {
  ControlPanel panel(kSettings, gpio_, clock_, log_);
  CommandQueue commands;
  for (const PanelInput& each : kSettings.inputs) {
    if (!each.press) continue;
    gpio_.pull(each.line.name, true, clock_.now() + 1ms);
    gpio_.pull(each.line.name, false, clock_.now() + 20ms);
    for (int frame = 0; frame < 5; ++frame) {
      clock_.advance(10ms);
      EXPECT_FALSE(panel.poll(commands));
    }
    EXPECT_EQ(commands.take(), each.press) << each.line.name;
    EXPECT_EQ(commands.take(), std::nullopt) << each.line.name;
  }
}

TEST_F(ControlPanelTest, NextInAPauseShowsTheNextCuesFirstFrame) {
  gpio_.pull("play", true, 403ms);
  gpio_.pull("play", false, 450ms);
  gpio_.pull("next", true, 603ms);
  gpio_.pull("play", true, 803ms);
  EXPECT_EQ(play(), LoopEnd::kOver);
  const std::vector<std::uint64_t> expected = undisturbed();
  ASSERT_EQ(screen_.flips().size(), 280U);
  for (std::size_t i = 0; i < 280; ++i) {
    ASSERT_EQ(screen_.flips()[i].hash, expected[i < 41 ? i : i < 61 ? 40 : i < 81 ? 100 : 20 + i]) << i;
  }
}

TEST_F(ControlPanelTest, APauseDoesNotOutlastTheTimeThatIsToBePlayed) {
  gpio_.pull("play", true, 403ms);
  EXPECT_EQ(play(650ms), LoopEnd::kTimeUp);
  EXPECT_EQ(screen_.flips().size(), 65U);
}

TEST_F(ControlPanelTest, LampTallyAndShutterFollowTheShow) {
  gpio_.pull("play", true, 303ms);  // held from 310 ms
  gpio_.pull("play", false, 400ms);
  gpio_.pull("play", true, 503ms);
  gpio_.pull("dark", true, 703ms);  // black at 720 ms
  gpio_.pull("dark", false, 803ms);
  play();
  EXPECT_EQ(writes("lamp", false, 0ms, 10ms), 1);
  EXPECT_EQ(writes("shutter", true, 0ms, 10ms), 1) << "shut until the first flip";
  EXPECT_EQ(writes("lamp", true, 10ms, 11ms), 1);
  EXPECT_EQ(writes("tally", true, 10ms, 11ms), 1);
  EXPECT_EQ(writes("shutter", false, 10ms, 11ms), 1);
  EXPECT_EQ(writes("tally", false, 320ms, 321ms), 1);
  EXPECT_EQ(writes("tally", true, 520ms, 521ms), 1);
  EXPECT_EQ(writes("shutter", true, 720ms, 721ms), 1);
  EXPECT_EQ(writes("shutter", false, 820ms, 821ms), 1);
  EXPECT_EQ(writes("lamp", false, 11ms, 3100ms), 0) << "pause and blackout leave it on";
  EXPECT_FALSE(gpio_.high("lamp"));
  EXPECT_FALSE(gpio_.high("tally"));
  EXPECT_FALSE(gpio_.high("trigger"));
  EXPECT_TRUE(gpio_.high("shutter"));
}

TEST_F(ControlPanelTest, TheCameraTriggerTurnsAtEveryFlip) {
  play();
  bool high = false;
  std::size_t flip = 0;
  for (const FakeGpioWrite& write : gpio_.writes()) {
    if (write.line != "trigger" || write.at < 10ms || flip == 300) continue;
    EXPECT_EQ(write.high, high = !high);
    EXPECT_EQ(write.at, screen_.flips()[flip++].at);
  }
  EXPECT_EQ(flip, 300U);
}

TEST_F(ControlPanelTest, ALostPanelStopsNothingAndComesBack) {
  gpio_.pull("dark", true, 203ms);
  gpio_.unplug("panel", 303ms);  // in the dark: which stays, as that was the last wish
  gpio_.plug("panel", 603ms);
  gpio_.pull("dark", false, 803ms);
  EXPECT_EQ(play(), LoopEnd::kOver);
  const std::string all = said(log_);
  EXPECT_NE(all.find(": the chip is gone ("), std::string::npos) << all;
  EXPECT_NE(all.find("cupola: gpio: the lines are back"), std::string::npos) << all;
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 2) << all;
  for (const Screen::Flip& flip : screen_.flips()) {
    ASSERT_EQ(flip.black, flip.at >= 220ms && flip.at < 820ms) << flip.at.count();
  }
  EXPECT_EQ(panel_->counts().losses, 1U);
  EXPECT_EQ(panel_->counts().returns, 1U);
  EXPECT_EQ(loop_->counts().frames_presented, 300);
  EXPECT_EQ(loop_->counts().frames_late, 0);
  EXPECT_EQ(writes("lamp", true, 600ms, 800ms), 1) << "the lamp is lit again";
}

TEST_F(ControlPanelTest, PlaysWithoutAPanelThatIsNotThere) {
  gpio_.take("lamp", true);
  EXPECT_EQ(play(), LoopEnd::kOver);
  EXPECT_EQ(said(log_), "cupola: gpio: lamp: taken by somebody else (request: Device or resource busy)\n");
  EXPECT_EQ(loop_->counts().frames_presented, 300);
}

}  // namespace
}  // namespace cupola
