// A show that is read again while it plays: which frames the flips show, what is refused, and what it costs.
// SPDX-License-Identifier: MIT
#include "firmware/show_reload.h"

#include <gmock/gmock.h>

#include <cstring>
#include <functional>
#include <utility>

#include "firmware/control_answers.h"
#include "firmware/frame_loop.h"
#include "firmware/heap_count.h"
#include "firmware/pattern_board.h"
#include "firmware/show_frames.h"
#include "pipeline/frame/still.h"
#include "pipeline/warp/table_cache.h"
#include "tests/firmware/watched_display.h"
#include "tests/frame/temporary_folder.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using testing::HasSubstr;

constexpr Size kSize{64, 48};
const std::vector<std::string> kRig = {"rig.frame.width=64", "rig.frame.height=48",
                                       "rig.frame.center=[32, 24]", "rig.frame.radius=30"};

std::string cue(const std::string& name, const std::string& world, const std::string& rest = "") {
  return "[[cue]]\nname = \"" + name + "\"\nsource = \"generated\"\nworld = \"" + world +
         "\"\nface_size = [32, 32]\n" + rest;
}

class Reload : public testing::Test {
 protected:
  void write(const std::string& cues) { write_text(file_, "rig = \"" + rig_ + "\"\n\n" + cues); }
  // A rig of the folder's own, which may be written again, unlike one that is overridden.
  void write_rig(int width, const std::string& rest = "", double tilt_deg = 0.0) {
    rig_ = "rig.toml";
    overrides_ = {};
    write_text(folder_ / rig_,
               "views = \"axis\"\ntilt_deg = " + std::to_string(tilt_deg) + "\n[frame]\nwidth = " +
                   std::to_string(width) + "\nheight = 48\ncenter = [32, 24]\nradius = 24\n" + rest +
                   "\n[lens]\nmodel = \"equidistant\"\nfov_deg = 180\n[[view]]\nname = \"top\"\n");
  }

  LoopCounts play(std::function<bool(int, const DisplayBuffer&)> next) {
    const Show show = load_show(file_, overrides_);
    auto first = std::make_unique<ReadyShow>();
    first->maker = std::make_unique<ShowFrames>(show, Method::kEwa, Cpu::kScalar, pool_);
    first->facts = facts_of(show, "fake");
    FrameMaker& maker = *first->maker;
    patterns_.emplace(kSize, pattern_drawer(show, Cpu::kScalar, TableCache()), link_.log);
    link_.patterns = &*patterns_;
    reload_.emplace(
        std::move(first),
        reopen_show(show, file_, overrides_, "", "fake", Cpu::kScalar, TableCache(),
                    show.sounds() ? std::optional(SoundMode{48000, 2}) : std::nullopt, &*patterns_),
        [](WorkerPool& pool) { join_frame_loop(pool); }, 2, kSize, link_.status, link_.log);
    link_.reload = &*reload_;
    test::WatchedDisplay display(clock_, kSize.width, kSize.height, std::move(next));
    FrameLoop loop(maker, display, clock_, pool_, nullptr, &link_);
    EXPECT_EQ(loop.run({}), LoopEnd::kClosed);
    reload_->end();
    return loop.counts();
  }
  void ask() { link_.commands.push({PlayerAction::kReload}); }
  // Whether what is shown is, to the bit, what the show as it is in the file shows at `time`.
  bool shows(const DisplayBuffer& shown, nanoseconds time) {
    ShowFrames frames(load_show(file_, overrides_), Method::kEwa, Cpu::kScalar, pool_);
    ImageBuffer whole(PixelFormat::kXrgb8888, kSize);
    frames.advance({time, time});
    frames.warp(whole.pixels(), 0);
    return same(shown, whole);
  }
  // Whether it is test pattern `pattern` of the rig as it is in the file.
  bool shows_pattern(const DisplayBuffer& shown, std::size_t pattern) {
    ImageBuffer whole(PixelFormat::kXrgb8888, kSize);
    pattern_drawer(load_show(file_, overrides_), Cpu::kScalar, TableCache())(pattern, whole.pixels());
    return same(shown, whole);
  }
  static bool same(const DisplayBuffer& shown, const ImageBuffer& whole) {
    for (int y = 0; y < kSize.height; ++y) {
      if (std::memcmp(shown.data + y * shown.stride, whole.pixels().planes[0].row(y), 256) != 0) return false;
    }
    return true;
  }
  static nanoseconds time_of(int flip) { return nanoseconds(1s) * flip / 60; }

  TemporaryFolder folder_;
  std::string rig_ = "omnimax";
  std::vector<std::string> overrides_ = kRig;
  const std::string file_ = folder_ / "show.toml";
  FakeClock clock_;
  WorkerPool pool_{2};
  ControlLink link_;
  std::optional<PatternBoard> patterns_;
  std::optional<ShowReload> reload_;
};

TEST_F(Reload, GoesOnInTheSameCueAtTheSameTimeAsIfItHadBeenSoFromTheStart) {
  write(cue("a", "grid"));
  int taken = -1;
  const LoopCounts counts = play([&](int flip, const DisplayBuffer& shown) {
    if (flip == 10) {
      write(cue("new", "grid") + cue("a", "demo"));
      ask();
    }
    if (taken < 0 && flip > 10 && reload_->reloads() == 1) taken = flip;
    if (taken < 0 || flip < taken + 30) return true;
    write(cue("a", "demo"));  // the same without the cue before
    EXPECT_TRUE(shows(shown, time_of(flip)));
    EXPECT_EQ(link_.status.read().show.cue, 1U);
    EXPECT_EQ(reload_->facts().cues.size(), 2U);
    return false;
  });
  EXPECT_GT(taken, 0);
  EXPECT_EQ(counts.frames_late, 0);
  EXPECT_EQ(counts.frames_dropped, 0);
  EXPECT_EQ(counts.blackout_frames, 0);
}

TEST_F(Reload, AllocatesNothingInTheLoop) {
  write(cue("a", "demo"));
  const LoopCounts counts = play([&](int flip, const DisplayBuffer&) {
    if (flip == 10) ask();
    return reload_->reloads() == 0;
  });
  EXPECT_EQ(reload_->reloads(), 1);
  EXPECT_EQ(counts.heap_allocations, 0);
}

TEST_F(Reload, OfABrokenFileLeavesTheShowAsItIsAndSaysWhere) {
  write(cue("a", "demo"));
  int said = -1;
  play([&](int flip, const DisplayBuffer& shown) {
    if (flip == 10) {
      write(cue("a", "demo", "lop = true\n"));
      ask();
    }
    if (said < 0 && !reload_->trouble().empty()) {
      EXPECT_THAT(reload_->trouble(), HasSubstr("show.toml:8: cue.0.lop"));
      write(cue("a", "demo"));
      said = flip;
    }
    if (said < 0 || flip < said + 10) return true;
    EXPECT_TRUE(shows(shown, time_of(flip)));
    return false;
  });
  EXPECT_GT(said, 0);
  EXPECT_EQ(reload_->reloads(), 0);
}

TEST_F(Reload, OfAMissingFileOrAnUnknownWorldOrALiveShowIsRefused) {
  write(cue("a", "demo"));
  int step = 0;
  play([&](int, const DisplayBuffer&) {
    const std::string trouble = reload_->trouble();
    if (step == 0) {
      std::filesystem::remove(file_);
      ask();
      step = 1;
    } else if (step == 1 && !trouble.empty()) {
      EXPECT_THAT(trouble, HasSubstr("show.toml"));
      write(cue("a", "live"));
      ask();
      step = 2;
    } else if (step == 2 && trouble.find("world") != std::string::npos) {
      write("[[cue]]\nname = \"a\"\nsource = \"live\"\n");
      ask();
      step = 3;
    } else if (step == 3 && trouble.find("live cues") != std::string::npos) {
      EXPECT_THAT(trouble, HasSubstr("needs a new start"));
      write(cue("a", "demo"));
      ask();
      step = 4;
    }
    return step < 4 || reload_->reloads() == 0;
  });
  EXPECT_EQ(step, 4);
  EXPECT_EQ(reload_->trouble(), "") << "the last one went well";
}

TEST_F(Reload, ThatWouldNeedAnotherFrameOrProjectorOrAMeasurementIsRefused) {
  const std::vector<std::pair<std::function<void()>, std::string>> changes = {
      {[&] { write_rig(60); }, "rig.toml: frame: 60 x 48 instead of 64 x 48 needs a new start"},
      {[&] { write_rig(64, "[display]\nmode = \"64x48\"\n"); },
       "rig.toml: display: other settings need a new start"},
      {[&] { write_rig(64, "[filter]\nbudget_ms = 8.0\n"); }, "rig.toml: filter.budget_ms: is measured"},
  };
  write_rig(64);
  write(cue("a", "demo"));
  std::size_t step = 0;
  bool asked = false;
  play([&](int flip, const DisplayBuffer& shown) {
    if (step == changes.size()) return false;
    if (!asked) {
      changes[step].first();
      ask();
      asked = true;
    } else if (reload_->trouble().find(changes[step].second) != std::string::npos) {
      write_rig(64);
      EXPECT_TRUE(shows(shown, time_of(flip))) << "the show goes on as it was";
      ++step;
      asked = false;
    }
    return true;
  });
  EXPECT_EQ(step, changes.size()) << reload_->trouble();
  EXPECT_EQ(reload_->reloads(), 0);
}

TEST_F(Reload, OfFilesThatHaveChangedShowsThem) {
  const auto paint = [&](std::uint8_t grey) {
    ImageBuffer picture(PixelFormat::kRgb8, {32, 32});
    for (int y = 0; y < 32; ++y) std::fill_n(picture.pixels().samples<std::uint8_t>(0, y), 96, grey);
    for (const char* view : {"front", "left", "right", "top"})
      write_png(folder_ / (std::string(view) + ".png"), as_const(picture.pixels()));
  };
  const auto middle = [](const DisplayBuffer& shown) {
    return std::to_integer<int>(shown.data[24 * shown.stride + 4 * 32]);
  };
  paint(50);
  write("[[cue]]\nname = \"a\"\nsource = \"stills\"\nfile = \"{view}.png\"\n");
  int done = -1;
  const LoopCounts counts = play([&](int flip, const DisplayBuffer& shown) {
    if (flip == 10) {
      paint(180);
      ask();
    }
    if (reload_->reloads() == 0) {
      EXPECT_TRUE(middle(shown) == 50 || middle(shown) == 180) << flip;
      return true;
    }
    EXPECT_EQ(middle(shown), 180) << flip;
    done = flip;
    return false;
  });
  EXPECT_GT(done, 0);
  EXPECT_EQ(counts.frames_failed, 0);
}

TEST_F(Reload, DuringAFadeOfCuesGoesOnInTheCueThatComes) {
  const auto cues = [](const std::string& second) {
    return cue("a", "demo", "duration_s = 0.5\n") + cue("b", second, "transition = \"fade\"\nfade_s = 100\n");
  };
  write(cues("demo"));
  int taken = -1;
  const LoopCounts counts = play([&](int flip, const DisplayBuffer&) {
    const PlayerStatus now = link_.status.read();
    if (flip == 60) {
      EXPECT_EQ(now.show.cue, 1U) << "the fade has begun";
      write(cues("grid"));
      ask();
    }
    if (taken < 0 && reload_->reloads() == 1) taken = flip;
    if (taken < 0 || flip < taken + 5) return true;
    EXPECT_EQ(now.show.cue, 1U);
    EXPECT_NEAR(std::chrono::duration<double>(now.show.position).count(),
                std::chrono::duration<double>(time_of(flip)).count() - 0.5, 0.1);
    return false;
  });
  EXPECT_GT(taken, 0);
  EXPECT_EQ(counts.blackout_frames, 0);
}

TEST_F(Reload, AskedForTwiceAtOnceEndsWithTheNewestFile) {
  write(cue("a", "demo"));
  int done = -1;
  play([&](int flip, const DisplayBuffer& shown) {
    if (flip == 10) {
      write(cue("a", "tree"));
      ask();
    }
    if (flip == 11) {
      write(cue("a", "grid"));
      ask();
    }
    if (done < 0 && flip > 11 && flip % 20 == 0 && reload_->reloads() >= 1 && shows(shown, time_of(flip)))
      done = flip;
    return done < 0;
  });
  EXPECT_GT(done, 0);
}

TEST_F(Reload, OfAnotherRigDrawsTestPatternsForThatOne) {
  constexpr std::size_t kGrid = 1;
  write_rig(64);
  write(cue("a", "demo"));
  int step = 0;
  link_.commands.push({.action = PlayerAction::kTestPattern, .cue = kGrid});
  const LoopCounts counts = play([&](int, const DisplayBuffer& shown) {
    const bool lies = link_.status.read().pattern == kGrid;
    if (step == 0 && lies) {
      EXPECT_TRUE(shows_pattern(shown, kGrid));
      write_rig(64, "", 30.0);
      EXPECT_FALSE(shows_pattern(shown, kGrid)) << "the rigs differ";
      ask();
      step = 1;
    } else if (step == 1) {
      EXPECT_TRUE(lies) << "it is not taken off meanwhile";
      if (reload_->reloads() == 0 || !shows_pattern(shown, kGrid)) return true;
      link_.commands.push({.action = PlayerAction::kTestPattern, .cue = 0});
      step = 2;
    } else if (step == 2 && !lies) {
      write_rig(64, "", 60.0);
      ask();
      step = 3;
    } else if (step == 3 && reload_->reloads() == 2) {
      link_.commands.push({.action = PlayerAction::kTestPattern, .cue = kGrid});
      step = 4;
    } else if (step == 4 && lies) {
      EXPECT_TRUE(shows_pattern(shown, kGrid)) << "never the one that lay there before";
      step = 5;
    }
    return step < 5;
  });
  EXPECT_EQ(step, 5);
  EXPECT_EQ(counts.frames_late, 0);
}

TEST_F(Reload, OfAShowWithAFirstOrABrokenSoundOrAnotherDeviceIsRefused) {
  const auto sounding = [](const std::string& sound) {
    return "[sound]\n" + sound + "\n" + cue("a", "demo", "sound = \"gone.wav\"\n");
  };
  const auto expect_refused = [&](const std::string& before, const std::string& after,
                                  const std::string& words) {
    write(before);
    bool asked = false;
    play([&](int, const DisplayBuffer&) {
      if (!asked) {
        write(after);
        ask();
        asked = true;
      }
      return reload_->trouble().empty() && reload_->reloads() == 0;
    });
    EXPECT_THAT(reload_->trouble(), HasSubstr(words));
  };
  expect_refused(cue("a", "demo"), sounding(""),
                 "show.toml: cue.0.sound: sound in a show that began without any needs a new start");
  expect_refused(sounding(""), sounding("device = \"other\""),
                 "show.toml: sound.device: another device needs a new start");
  expect_refused(sounding(""), sounding(""), "cue a: ");  // its file
  EXPECT_THAT(reload_->trouble(), HasSubstr("gone.wav"));
  expect_refused(sounding(""), sounding("channels = 6"), "show.toml: sound.channels: another number needs");
  expect_refused(sounding(""), sounding("master = true"), "show.toml: sound.master: another master needs");
}

TEST_F(Reload, DuringAFadeKeepsTheLight) {
  write(cue("a", "grid"));
  link_.commands.push({PlayerAction::kFadeOut, 10000s});
  int taken = -1;
  play([&](int flip, const DisplayBuffer&) {
    if (flip == 600) ask();
    if (taken < 0 && reload_->reloads() == 1) taken = flip;
    if (taken < 0 || flip < taken + 5) return true;
    const double light = link_.status.read().light;
    EXPECT_NEAR(light, 1.0 - std::chrono::duration<double>(time_of(flip)).count() / 10000.0, 1e-4);
    return false;
  });
  EXPECT_GT(taken, 0);
}

TEST_F(Reload, WithoutTheCueThatPlaysBeginsAtTheFirst) {
  write(cue("a", "demo"));
  int taken = -1;
  play([&](int flip, const DisplayBuffer&) {
    if (flip == 10) {
      write(cue("b", "grid"));
      ask();
    }
    if (taken < 0 && reload_->reloads() == 1) taken = flip;
    if (taken < 0 || flip < taken + 2) return true;
    EXPECT_LT(link_.status.read().show.position, time_of(flip - 8));
    return false;
  });
  EXPECT_GT(taken, 0);
}

}  // namespace
}  // namespace cupola
