// A show's sound under the fake clock: where it is heard, what the operator does to it, what goes wrong.
// SPDX-License-Identifier: MIT
#include "firmware/show_sound.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <thread>

#include "firmware/control_answers.h"
#include "firmware/frame_loop.h"
#include "firmware/heap_count.h"
#include "firmware/show_frames.h"
#include "hal/display/fake_display.h"
#include "hal/sound/fake_sound.h"
#include "tests/firmware/said.h"
#include "tests/hal/sanitized.h"
#include "tests/sound/fake_track.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr int kRate = 8000;

// Time that passes at the loop's flips; the sound's thread takes its turns meanwhile, and a test looks on.
class SteppingClock final : public Clock {
 public:
  nanoseconds now() noexcept override { return clock_.now(); }
  void sleep_until(nanoseconds deadline) noexcept override {
    for (; next_ <= deadline; next_ += ShowSound::kTurn) {
      clock_.sleep_until(next_);
      if (on_turn) on_turn();
    }
    clock_.sleep_until(deadline);
  }
  bool wait(std::span<const int> descriptors, nanoseconds deadline) noexcept override {
    return clock_.wait(descriptors, deadline);
  }
  int add_alarm() override { return clock_.add_alarm(); }
  void set_alarm(int alarm, nanoseconds when) noexcept override { clock_.set_alarm(alarm, when); }
  std::function<void()> on_turn;

 private:
  FakeClock clock_;
  nanoseconds next_{0};
};

Show small_show(const std::string& cues) {
  const std::string lines[] = {"rig.frame.width=16", "rig.frame.height=12", "rig.frame.center=[8, 6]",
                               "rig.frame.radius=8", "cue=[" + cues + "]"};
  return load_show("demo", lines);
}

std::string cue(const std::string& name, const std::string& more = "") {
  return R"({name=")" + name + R"(", source="test-pattern", world="white", face_size=[8, 8])" + more + "},";
}

// The frame loop that is shipped, its show, and the sound of it on a fake card.
struct Stage {
  explicit Stage(const std::string& cues, SoundSettings settings = {}, FakeSoundFaults faults = {},
                 std::int64_t track_frames = std::int64_t{20000} * kRate, bool loop_sound = false,
                 std::int64_t breaks_at = INT64_MAX)
      : show(small_show(cues)),
        frames(show, Method::kEwa, Cpu::kScalar, pool),
        card(clock, {kRate, 1}, std::move(faults)),
        display(clock, 16, 12),
        loop(frames, display, clock, pool, nullptr, &link) {
    std::vector<CueSound> sounds(show.cues.size());
    for (std::size_t i = 0; i < sounds.size(); ++i) {
      sounds[i].cue = show.cues[i].name;
      sounds[i].fade = nanoseconds(std::llround(show.cues[i].fade_s * 1e9));
      sounds[i].length = track_frames;
      if (show.cues[i].name.starts_with("mute")) continue;
      SoundPart part;
      part.loop = loop_sound;
      if (loop_sound) part.length = track_frames;
      sounds[i].ahead = std::make_unique<SoundAhead>(std::make_unique<FakeTrack>(track_frames, 1, breaks_at),
                                                     1, part, 16384, true);
    }
    const bool opened = card.open({kRate, 1}).has_value();
    sound.emplace(settings,
                  std::make_unique<SoundSet>(SoundSet{std::move(sounds), frames.timeline(), settings.delay}),
                  card, SoundMode{kRate, 1}, opened, clock, link);
    clock.on_turn = [this] {
      sound->step();
      if (look) look();
    };
  }
  // Where in its track the sound is that is heard now; below 0: silence, or on a ramp.
  double heard_s() { return FakeTrack::frame(static_cast<double>(card.sounding())) / kRate; }
  bool silent() { return card.sounding() == 0.0F; }
  // Where the show is now.
  double show_s() const {
    const PlayerStatus status = link.status.read();
    return std::chrono::duration<double>(status.show.position + (clock_now() - status.due)).count();
  }
  nanoseconds clock_now() const { return const_cast<SteppingClock&>(clock).now(); }
  double off_ms() { return 1e3 * (heard_s() - show_s()); }
  LoopEnd run(nanoseconds time) { return loop.run(time); }

  SteppingClock clock;
  WorkerPool pool{1};
  ControlLink link;
  Show show;
  ShowFrames frames;
  FakeSound card;
  FakeDisplay display;
  FrameLoop loop;
  std::optional<ShowSound> sound;
  std::function<void()> look;
};

// Largest |sound heard - show's time| from `after` on, over an hour of one cue.
struct Hour {
  double worst_ms = 0.0;
  SoundReport report;
  LoopCounts counts;
  double applied_worst_ppm = 0.0;
};
Hour an_hour(const SoundSettings& settings, const FakeSoundFaults& faults) {
  Stage stage(cue("long"), settings, faults);
  Hour hour;
  stage.look = [&] {
    if (stage.clock.now() < 10s) return;
    hour.worst_ms = std::max(hour.worst_ms, std::abs(stage.off_ms()));
    hour.applied_worst_ppm = std::max(hour.applied_worst_ppm, std::abs(stage.sound->report().applied_ppm));
  };
  EXPECT_EQ(stage.run(test::kSanitized ? 2min : 60min), LoopEnd::kTimeUp);
  hour.report = stage.sound->report();
  hour.counts = stage.loop.counts();
  return hour;
}

TEST(ShowSoundTest, AnHourOfACrystalThatIsOffStaysWithinTwoMilliseconds) {
  for (const double ppm : {200.0, -200.0}) {
    const Hour hour = an_hour({}, {.ppm = ppm});
    std::printf("sound at %+.0f ppm: at most %.3f ms off, corrected by at most %.0f ppm\n", ppm,
                hour.worst_ms, hour.applied_worst_ppm);
    // A good part of it is the samples', which tell only every fourth frame by then.
    EXPECT_LT(hour.worst_ms, 2.0);
    EXPECT_LT(hour.applied_worst_ppm, 300.0);
    EXPECT_NEAR(hour.report.device_ppm, ppm, 5.0);
    EXPECT_LT(std::abs(hour.report.drift.count()), 1'000'000);
    EXPECT_EQ(hour.report.underruns, 0);
    EXPECT_EQ(hour.report.missing, 0);
    EXPECT_EQ(hour.counts.heap_allocations, 0);
  }
}

TEST(ShowSoundTest, AnHourAsMasterTakesThePicturesAlongAndDropsNone) {
  for (const double ppm : {200.0, -200.0}) {
    const Hour hour = an_hour({.master = true}, {.ppm = ppm, .grain = 40, .jitter = 2ms});
    std::printf("as master at %+.0f ppm with jitter: at most %.3f ms off, paced by at most %.0f ppm\n", ppm,
                hour.worst_ms, hour.applied_worst_ppm);
    // Half a block of what the card counts in cannot be known, and float samples this late tell 2 frames.
    EXPECT_LT(hour.worst_ms, 5.0);
    EXPECT_LT(hour.applied_worst_ppm, 1500.0);
    EXPECT_NEAR(hour.report.applied_ppm, ppm, 100.0);
    EXPECT_EQ(hour.report.underruns, 0);
    EXPECT_EQ(hour.counts.frames_dropped, 0);
    EXPECT_EQ(hour.counts.frames_late, 0);
    EXPECT_EQ(hour.counts.heap_allocations, 0);
  }
}

TEST(ShowSoundTest, AsMasterThePicturesNeverJumpByMoreThanAFrame) {
  Stage stage(cue("long"), {.master = true}, {.ppm = 200.0, .grain = 40, .jitter = 2ms});
  nanoseconds last_due{0};
  nanoseconds last_position{0};
  std::int64_t worst = 0;
  stage.look = [&] {
    const PlayerStatus status = stage.link.status.read();
    if (status.due == last_due) return;
    if (last_due.count() > 0) {
      const std::int64_t more = (status.show.position - last_position - (status.due - last_due)).count();
      worst = std::max(worst, std::abs(more));
    }
    last_due = status.due;
    last_position = status.show.position;
  };
  stage.run(60s);
  EXPECT_GT(worst, 0) << "it follows";
  EXPECT_LE(worst, 16'666'667 / 100) << "no flip's share is off by a hundredth of a frame";
}

TEST(ShowSoundTest, ADeviceThatPlaysLateIsHeardInTime) {
  Stage stage(cue("long"), {}, {.latency = 120ms});
  double worst = 0.0;
  stage.look = [&] {
    if (stage.clock.now() > 5s) worst = std::max(worst, std::abs(stage.off_ms()));
  };
  stage.run(20s);
  EXPECT_LT(worst, 1.0);
}

TEST(ShowSoundTest, TheDelayOfTheShowFileIsKept) {
  Stage stage(cue("long"), {.delay = 40ms});
  double sum = 0.0;
  int count = 0;
  stage.look = [&] {
    if (stage.clock.now() < 5s) return;
    sum += stage.off_ms();
    ++count;
  };
  stage.run(20s);
  EXPECT_NEAR(sum / count, -40.0, 0.5) << "the sound is heard later than the picture is flipped";
}

TEST(ShowSoundTest, APauseSilencesItAndPlayGoesOnFromThere) {
  Stage stage(cue("long"));
  double silent_after = 0.0;
  double worst = 0.0;
  bool paused = false;
  bool played = false;
  stage.look = [&] {
    const nanoseconds now = stage.clock.now();
    if (now >= 2s && !std::exchange(paused, true)) stage.link.commands.push({PlayerAction::kPause});
    if (now >= 5s && !std::exchange(played, true)) stage.link.commands.push({PlayerAction::kPlay});
    if (now > 2s && now < 5s && !stage.silent())
      silent_after = std::chrono::duration<double>(now - 2s).count();
    if (now > 6s) worst = std::max(worst, std::abs(stage.off_ms()));
  };
  stage.run(10s);
  EXPECT_LT(silent_after, 0.11) << "what the device already has, and the ramp";
  EXPECT_LT(worst, 1.0);
  EXPECT_NEAR(stage.heard_s(), 7.0, 0.05) << "three of ten seconds stood still";
}

TEST(ShowSoundTest, FollowsSeeksJumpsAndCutsToTheFrame) {
  Stage stage(cue("first", ", duration_s=1000, loop=true") + cue("second"));
  std::vector<std::pair<nanoseconds, PlayerCommand>> orders = {
      {2s, {PlayerAction::kSeek, 700s}},
      {4s, {PlayerAction::kSeek, 1s}},
      {6s, {PlayerAction::kNext}},
      {8s, {PlayerAction::kPrevious}},
      {10s, {.action = PlayerAction::kCue, .cue = 1}},
      {12s, {PlayerAction::kSeek, 1234s}}};
  std::size_t given = 0;
  double worst = 0.0;
  stage.look = [&] {
    const nanoseconds now = stage.clock.now();
    if (given < orders.size() && now >= orders[given].first) stage.link.commands.push(orders[given++].second);
    // Within a tenth of a second after each order it is where it belongs.
    const nanoseconds since = now - (given > 0 ? orders[given - 1].first : 0s);
    if (now > 500ms && since > 120ms) worst = std::max(worst, std::abs(stage.off_ms()));
  };
  stage.run(14s);
  EXPECT_EQ(given, orders.size());
  EXPECT_LT(worst, 1.0);
  EXPECT_EQ(stage.sound->report().underruns, 0);
}

TEST(ShowSoundTest, ACueThatFollowsBeginsOnItsFrameWithoutAGap) {
  Stage stage(cue("first", ", duration_s=2") + cue("second", ", duration_s=2") + cue("mute"));
  double worst = 0.0;
  stage.look = [&] {
    const nanoseconds now = stage.clock.now();
    if (now > 2100ms && now < 3900ms)
      worst = std::max(worst, std::abs(stage.heard_s() - std::chrono::duration<double>(now - 2s).count()));
    if (now > 4200ms) {
      EXPECT_TRUE(stage.silent());
    }
  };
  stage.run(5s);
  EXPECT_LT(worst, 0.02) << "the show begins one flip after the clock";
}

TEST(ShowSoundTest, ALoopGoesRoundWithItsPictures) {
  Stage stage(cue("long"), {}, {}, 3 * kRate, true);
  double worst = 0.0;
  stage.look = [&] {
    if (stage.clock.now() < 1s) return;
    const double shown = std::fmod(stage.show_s(), 3.0);
    if (shown > 0.05 && shown < 2.95) worst = std::max(worst, std::abs(stage.heard_s() - shown));
  };
  stage.run(20s);
  EXPECT_LT(worst, 1e-3);
}

TEST(ShowSoundTest, AnUnderrunIsCountedAndTheSoundIsAtOnceWhereTheShowIs) {
  Stage stage(cue("long"), {}, {.underruns = {3s, 5s}});
  double worst = 0.0;
  stage.look = [&] {
    const nanoseconds now = stage.clock.now();
    if ((now > 1s && now < 2900ms) || (now > 3100ms && now < 4900ms) || now > 5100ms)
      worst = std::max(worst, std::abs(stage.off_ms()));
  };
  stage.run(8s);
  EXPECT_EQ(stage.sound->report().underruns, 2);
  EXPECT_LT(worst, 1.0);
}

TEST(ShowSoundTest, ALostDeviceNeverStopsThePictureIsSaidOnceAndComesBack) {
  for (const bool master : {false, true}) {
    Stage stage(cue("long"), {.master = master}, {.absences = {{2s, 7s}}});
    double worst = 0.0;
    stage.look = [&] {
      if (stage.clock.now() > 8500ms) worst = std::max(worst, std::abs(stage.off_ms()));
      if (stage.clock.now() == 4s) {
        EXPECT_FALSE(stage.sound->report().working);
        EXPECT_STREQ(stage.sound->report().trouble.data(), "unplugged on demand");
        EXPECT_EQ(stage.link.pace_ppb, 0);
      }
    };
    stage.run(12s);
    EXPECT_EQ(said(stage.link.log),
              "cupola: the sound device is away: unplugged on demand\ncupola: the sound device is back\n");
    EXPECT_LT(worst, 1.0);
    EXPECT_EQ(stage.sound->report().losses, 1);
    EXPECT_EQ(stage.loop.counts().frames_presented, 720);
    EXPECT_EQ(stage.loop.counts().frames_late, 0);
  }
}

TEST(ShowSoundTest, ADeviceThatIsNotThereAtFirstIsTakenWhenItComes) {
  Stage stage(cue("long"), {}, {.absences = {{0s, 3s}}});
  stage.run(6s);
  EXPECT_EQ(said(stage.link.log),
            "cupola: the sound device is away: unplugged on demand\ncupola: the sound device is back\n");
  EXPECT_LT(std::abs(stage.off_ms()), 1.0);
}

TEST(ShowSoundTest, ShortWritesLoseNothing) {
  Stage stage(cue("long"), {}, {.most_a_write = 37});
  double worst = 0.0;
  stage.look = [&] {
    if (stage.clock.now() > 2s) worst = std::max(worst, std::abs(stage.off_ms()));
  };
  stage.run(10s);
  EXPECT_LT(worst, 1.0);
  EXPECT_EQ(stage.sound->report().underruns, 0);
}

TEST(ShowSoundTest, ASoundThatIsBrokenIsNamedOnceAndTheShowGoesOn) {
  Stage stage(cue("long"), {}, {}, 100 * kRate, false, 3 * kRate);
  stage.run(6s);
  EXPECT_EQ(said(stage.link.log),
            "cupola: cue long: fake.wav: is broken there; it is silent from there on\n");
  EXPECT_TRUE(stage.silent());
  EXPECT_EQ(stage.loop.counts().frames_presented, 360);
}

TEST(ShowSoundTest, VolumeIsACubeOfItsPercentAndBlackoutsLeaveItAlone) {
  Stage stage(cue("long"), {.volume = 50});
  stage.link.commands.push({.action = PlayerAction::kVolume, .volume = 50});
  stage.link.commands.push({PlayerAction::kBlackout});
  stage.run(5s);
  const double ratio = static_cast<double>(stage.card.sounding()) /
                       static_cast<double>(FakeTrack::sample(std::llround(stage.show_s() * kRate)));
  EXPECT_NEAR(ratio, 0.125, 1e-3);
  stage.link.commands.push({.action = PlayerAction::kVolumeBy, .volume = -60});
  stage.run(1s);
  EXPECT_EQ(stage.link.status.read().volume, 0);
  EXPECT_EQ(stage.card.sounding(), 0.0F);
}

TEST(ShowSoundTest, AShowThatIsResumedSoundsFromItsPlace) {
  Stage stage(cue("first", ", duration_s=10") + cue("second"));
  ASSERT_TRUE(stage.frames.begin_in(1, 345s));
  stage.run(3s);
  EXPECT_NEAR(stage.heard_s(), 348.0, 0.1);
  EXPECT_LT(std::abs(stage.off_ms()), 1.0);
}

TEST(ShowSoundTest, ACueThatFadesInLetsTheOldSoundFallWhileItDoes) {
  Stage stage(cue("first", ", duration_s=2") + cue("mute", R"(, transition="fade", fade_s=1, duration_s=5)"));
  float at_half = 0.0F;
  stage.look = [&] {
    const nanoseconds now = stage.clock.now();
    if (now >= 2510ms && at_half == 0.0F) at_half = stage.card.sounding();
    if (now > 3200ms) {
      EXPECT_TRUE(stage.silent());
    }
  };
  stage.run(4s);
  EXPECT_NEAR(at_half / FakeTrack::sample(2500 * kRate / 1000), 0.5, 0.05);
}

constexpr int kNoFile = -1;

// Sounds that tell which one they are: file n begins 1000 n seconds into the track.
std::unique_ptr<SoundSet> sounds_of(const Timeline& timeline, const std::vector<int>& files,
                                    bool in_step = true) {
  auto set = std::make_unique<SoundSet>(SoundSet{std::vector<CueSound>(files.size()), timeline});
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (files[i] == kNoFile) continue;
    set->sounds[i].ahead = std::make_unique<SoundAhead>(
        std::make_unique<FakeTrack>(std::int64_t{20000} * kRate), 1,
        SoundPart{.first = std::int64_t{1000} * files[i] * kRate}, 16384, in_step);
  }
  return set;
}

// A show that is read again as `cues` with `files`, which are set before it is asked for.
struct Again {
  Again(const Show& now, ControlLink& link, bool in_step = true)
      : reload(
            first(now), [this, in_step](ReadyShow& ready, bool) { return open(ready, in_step); },
            [](WorkerPool& pool) { join_frame_loop(pool); }, 1, {16, 12}, link.status, link.log) {
    link.reload = &reload;
  }
  static std::unique_ptr<ReadyShow> first(const Show& now) {
    auto ready = std::make_unique<ReadyShow>();
    ready->facts = facts_of(now, "fake");
    return ready;
  }
  bool open(ReadyShow& ready, bool in_step) const {
    const Show show = small_show(cues);
    auto frames = std::make_unique<ShowFrames>(show, Method::kEwa, Cpu::kScalar, *ready.pool);
    ready.open_sounds = [timeline = frames->timeline(), files = files, in_step](const Timeline::Place&) {
      return sounds_of(timeline, files, in_step);
    };
    ready.facts = facts_of(show, "fake");
    ready.maker = std::move(frames);
    return false;
  }
  std::string cues;
  std::vector<int> files;
  ShowReload reload;
};

struct ReloadStage : Stage {
  ReloadStage(const std::string& cues, const std::vector<int>& files, SoundSettings settings = {})
      : Stage(cues, settings), again(show, link) {
    sound.emplace(settings, sounds_of(frames.timeline(), files), card, SoundMode{kRate, 1}, true, clock,
                  link);
    // The side takes its time, of which the clock knows nothing.
    look = [this] {
      if (asked > again.reload.reloads()) std::this_thread::sleep_for(1ms);
      if (on_look) on_look();
    };
  }
  ~ReloadStage() { sound.reset(); }
  void prepare(const std::string& cues, std::vector<int> files) {
    again.cues = cues;
    again.files = std::move(files);
  }
  void ask() {
    link.commands.push({PlayerAction::kReload});
    ++asked;
  }
  bool taken() const { return link.status.read().show_number == asked; }
  // Heard is that file, where the show is.
  bool plays(int file) { return std::abs(heard_s() - 1000.0 * file - show_s()) < 2e-3; }

  Again again;
  int asked = 0;
  std::function<void()> on_look;
};

TEST(ShowSoundTest, AShowThatIsReadAgainIsHeardWhereItStandsAndNoFileOfAnotherCue) {
  for (const bool master : {false, true}) {
    ReloadStage stage(cue("first", ", duration_s=1") + cue("second"), {0, 1}, {.master = master});
    stage.prepare(cue("second") + cue("new") + cue("first"), {2, 3, 4});  // allocates
    nanoseconds taken_at{0};
    int strays = 0;
    stage.on_look = [&] {
      const nanoseconds now = stage.clock.now();
      if (now == 3s) stage.ask();
      if (now <= 2s) return;
      if (taken_at == 0ns && stage.asked > 0 && stage.taken()) taken_at = now;
      if (taken_at == 0ns) {
        EXPECT_TRUE(stage.plays(1)) << now.count();
      } else if (now > taken_at + 120ms) {
        EXPECT_TRUE(stage.plays(2)) << now.count();
      } else {
        strays += stage.plays(1) || stage.plays(2) ? 0 : 1;
      }
      if (taken_at > 0ns && now > taken_at + 3s) stage.display.close();
    };
    EXPECT_EQ(stage.run(600s), LoopEnd::kClosed);
    EXPECT_LE(strays, 2) << "5 ms down and 5 ms up, seen every 10 ms";
    EXPECT_EQ(stage.sound->report().underruns, 0);
    EXPECT_EQ(stage.sound->report().missing, 0);
    EXPECT_EQ(stage.loop.counts().heap_allocations, 0);
    EXPECT_EQ(stage.loop.counts().frames_late, 0);
    EXPECT_EQ(stage.loop.counts().frames_dropped, 0);
  }
}

TEST(ShowSoundTest, AShowIsReadAgainAgainAndAgainAlsoWhileASoundFades) {
  ReloadStage stage(cue("first", ", duration_s=1") + cue("b", R"(, transition="fade", fade_s=500)"), {0, 1});
  nanoseconds taken_at = 2s;
  stage.on_look = [&] {
    const nanoseconds now = stage.clock.now();
    if (now <= 2s || !stage.taken()) return;
    if (taken_at == 0ns) taken_at = now;
    if (now < taken_at + 500ms) return;
    const int file = stage.asked + 1;
    if (stage.asked > 0 && stage.asked != 4) {  // at first the old sound still falls
      EXPECT_TRUE(stage.plays(file)) << stage.asked;
    }
    if (stage.asked == 4) {
      EXPECT_TRUE(stage.silent());
    }
    if (stage.asked == 7) return stage.display.close();
    taken_at = 0ns;
    stage.prepare(cue("b"), {stage.asked == 3 ? kNoFile : file + 1});
    stage.ask();
  };
  EXPECT_EQ(stage.run(600s), LoopEnd::kClosed);
  EXPECT_EQ(stage.loop.counts().frames_late, 0);
}

// For the thread sanitizer: the loop, the sound's thread and the reload's, on the real clock.
TEST(ShowSoundTest, AShowIsReadAgainBesideTheLoopAndTheSoundsThread) {
  WorkerPool pool(1);
  MonotonicClock clock;
  const Show show = small_show(cue("first"));
  ShowFrames frames(show, Method::kEwa, Cpu::kScalar, pool);
  FakeDisplay display(clock, 16, 12);
  ControlLink link;
  FrameLoop loop(frames, display, clock, pool, nullptr, &link);
  FakeSound card(clock, {kRate, 1});
  card.open({kRate, 1});
  Again again(show, link, false);
  again.cues = cue("first");
  again.files = {1};
  ShowSound sound({}, sounds_of(frames.timeline(), {0}, false), card, {kRate, 1}, true, clock, link);
  std::atomic<bool> over{false};
  std::thread thread([&] {
    while (!over) {
      sound.step();
      clock.sleep_until(clock.now() + ShowSound::kTurn);
    }
  });
  std::thread operator_thread([&] {
    for (int i = 0; i < 20; ++i) {
      link.commands.push({PlayerAction::kReload});
      clock.sleep_until(clock.now() + 50ms);
    }
  });
  loop.run(1200ms);
  operator_thread.join();
  over = true;
  thread.join();
  EXPECT_GT(again.reload.reloads(), 0);
  EXPECT_EQ(again.reload.trouble(), "");
  EXPECT_EQ(loop.counts().heap_allocations, 0);
}

// For the thread sanitizer: the loop and the sound's thread, both on the real clock.
TEST(ShowSoundTest, RunsBesideTheLoopOnAThreadOfItsOwn) {
  WorkerPool pool(1);
  MonotonicClock clock;
  const Show show = small_show(cue("first", ", duration_s=0.3") + cue("second"));
  ShowFrames frames(show, Method::kEwa, Cpu::kScalar, pool);
  FakeDisplay display(clock, 16, 12);
  ControlLink link;
  FrameLoop loop(frames, display, clock, pool, nullptr, &link);
  FakeSound card(clock, {kRate, 1});
  std::vector<CueSound> sounds(2);
  for (CueSound& one : sounds)
    one.ahead = std::make_unique<SoundAhead>(std::make_unique<FakeTrack>(std::int64_t{1000} * kRate), 1,
                                             SoundPart{}, 16384, false);
  card.open({kRate, 1});
  ShowSound sound({.master = true},
                  std::make_unique<SoundSet>(SoundSet{std::move(sounds), frames.timeline()}), card,
                  {kRate, 1}, true, clock, link);
  std::atomic<bool> over{false};
  std::thread thread([&] {
    while (!over) {
      sound.step();
      clock.sleep_until(clock.now() + ShowSound::kTurn);
    }
  });
  loop.run(1s);
  over = true;
  thread.join();
  EXPECT_GT(loop.counts().frames_presented, 10);
  EXPECT_EQ(loop.counts().heap_allocations, 0);
  EXPECT_TRUE(read_status(link).sound.working);
}

}  // namespace
}  // namespace cupola
