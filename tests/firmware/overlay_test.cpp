// Test patterns over a running show, and screenshots of what is presented.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <set>

#include "firmware/frame_loop.h"
#include "firmware/show_frames.h"
#include "pipeline/frame/still.h"
#include "pipeline/source/world.h"
#include "pipeline/warp/table_cache.h"
#include "tests/firmware/watched_display.h"
#include "tests/frame/temporary_folder.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr Size kSize{64, 48};
using Pixels = std::vector<std::uint32_t>;

Show show_of(const std::string& cue) {
  const std::string lines[] = {"rig.frame.width=64", "rig.frame.height=48", "rig.frame.center=[32, 24]",
                               "rig.frame.radius=30", "cue=[{name=\"a\", face_size=[32, 32], " + cue + "}]"};
  return load_show("demo", lines);
}
Show demo() {
  return show_of(R"(source="generated", world="demo")");
}

Pixels pixels_of(const Image& image) {
  Pixels pixels;
  for (int y = 0; y < image.size.height; ++y) {
    const auto* row = image.samples<std::uint32_t>(0, y);
    pixels.insert(pixels.end(), row, row + image.size.width);
  }
  return pixels;
}

// The frame at `time`, made whole.
Pixels frame_of(const Show& show, nanoseconds time, WorkerPool& pool) {
  ShowFrames frames(show, Method::kEwa, Cpu::kScalar, pool);
  ImageBuffer frame(PixelFormat::kXrgb8888, kSize);
  frames.advance({time, time});
  frames.warp(frame.pixels(), 0);
  return pixels_of(frame.pixels());
}

Pixels pixels_of(const DisplayBuffer& front) {
  Pixels pixels(std::size_t{64} * 48);
  for (int y = 0; y < 48; ++y) std::memcpy(&pixels[64UL * y], front.data + y * front.stride, 256);
  return pixels;
}

class Overlay : public testing::Test {
 protected:
  // What the display does meanwhile allocates on the loop's thread: `counts` knows of it.
  LoopCounts play(const Show& show, std::function<bool(int, const Pixels&)> next) {
    ShowFrames frames(show, Method::kEwa, Cpu::kScalar, pool_);
    test::WatchedDisplay display(
        clock_, kSize.width, kSize.height,
        [&](int flip, const DisplayBuffer& front) { return next(flip, pixels_of(front)); });
    FrameLoop loop(frames, display, clock_, pool_, nullptr, &link_);
    EXPECT_EQ(loop.run({}), LoopEnd::kClosed);
    return loop.counts();
  }
  FakeClock clock_;
  WorkerPool pool_{2};
  ControlLink link_;
  const Show show_ = demo();
};

TEST_F(Overlay, APatternIsLaidAsACueWouldShowItAndTheShowsTimeGoesOnBelow) {
  const Pixels expected = frame_of(show_of(R"(source="test-pattern", world="alignment")"), 0ns, pool_);
  PatternBoard board(kSize, pattern_drawer(show_, Cpu::kScalar, TableCache()), link_.log);
  link_.patterns = &board;
  int laid = -1;
  int off = -1;
  const LoopCounts counts = play(show_, [&](int flip, const Pixels& pixels) {
    if (flip == 5) link_.commands.push(parse_command("test-pattern", "alignment", {}));
    if (laid < 0 && pixels == expected) laid = flip;
    if (laid >= 0 && flip == laid + 20) {
      EXPECT_EQ(pixels, expected) << "it stands";
      EXPECT_EQ(link_.status.read().pattern, 2U);
      link_.commands.push(parse_command("test-pattern", "off", {}));
      off = flip + 1;
    }
    if (flip == off) {
      EXPECT_EQ(pixels, frame_of(show_, nanoseconds(1s) * flip / 60, pool_));
    }
    return off < 0 || flip < off;
  });
  EXPECT_GE(laid, 6);
  EXPECT_EQ(counts.frames_late, 0);
  EXPECT_EQ(link_.status.read().pattern, 0U);
}

TEST(TestPatterns, AreWorlds) {
  for (const std::string_view name : test_patterns()) EXPECT_TRUE(make_world(name)) << name;
}

TEST_F(Overlay, PatternsFollowOneAnotherWithoutTheShowBetween) {
  PatternBoard board(
      kSize,
      [](std::size_t pattern, const MutableImage& into) {
        for (int y = 0; y < 48; ++y) {
          std::fill_n(into.samples<std::uint32_t>(0, y), 64,
                      0xff000000U + static_cast<std::uint32_t>(pattern));
        }
      },
      link_.log);
  link_.patterns = &board;
  std::size_t wanted = 0;
  const LoopCounts counts = play(show_, [&](int, const Pixels& pixels) {
    const std::size_t laid = board.laid();
    if (wanted > 1) {
      EXPECT_NE(laid, 0U);
    }
    if (laid != 0) {
      EXPECT_EQ(pixels.front() & 0xffU, laid);
    }
    if (laid == wanted && wanted < 10) {
      ++wanted;
      link_.commands.push({PlayerAction::kTestPatternNext});
    } else if (laid == 10) {
      return false;
    }
    return true;
  });
  EXPECT_EQ(wanted, 10U);
  EXPECT_LT(counts.frames_presented, 60000);
}

TEST_F(Overlay, ABlackoutIsDarkerThanAPatternAndAFadeDimsIt) {
  PatternBoard board(
      kSize,
      [](std::size_t, const MutableImage& into) {
        for (int y = 0; y < 48; ++y) std::fill_n(into.samples<std::uint32_t>(0, y), 64, 0xff808080U);
      },
      link_.log);
  link_.patterns = &board;
  link_.commands.push({PlayerAction::kTestPattern, {}, 1});
  int laid = -1;
  bool dimmed = false;
  play(show_, [&](int flip, const Pixels& pixels) {
    if (laid < 0 && pixels.front() == 0xff808080U) {
      laid = flip;
      link_.commands.push({PlayerAction::kFadeOut, 500ms});
    }
    dimmed = dimmed || (pixels.front() > 0xff202020U && pixels.front() < 0xff606060U);
    if (laid >= 0 && flip == laid + 40) {
      EXPECT_EQ(pixels.front(), 0xff000000U);
      link_.commands.push({PlayerAction::kBlackoutOff});
    }
    if (laid >= 0 && flip == laid + 42) {
      EXPECT_EQ(pixels.front(), 0xff808080U);
      return false;
    }
    return true;
  });
  EXPECT_TRUE(dimmed);
}

TEST_F(Overlay, APatternThatCannotBeDrawnLeavesTheShowAlone) {
  PatternBoard board(
      kSize, [](std::size_t, const MutableImage&) { throw std::runtime_error("no paint"); }, link_.log);
  link_.patterns = &board;
  link_.commands.push({PlayerAction::kTestPattern, {}, 1});
  bool said = false;
  play(show_, [&](int, const Pixels&) {
    for (const EventLog::Line& line : link_.log.lines())
      said = said || line.text == "test-pattern grid: no paint";
    return !said;
  });
  EXPECT_TRUE(said);
}

// Every screenshot of `commands`, one after the other, is to the bit a frame that was presented.
TEST_F(Overlay, AScreenshotIsAFrameThatWasPresented) {
  PatternBoard board(
      kSize,
      [](std::size_t, const MutableImage& into) {
        for (int y = 0; y < 48; ++y) std::fill_n(into.samples<std::uint32_t>(0, y), 64, 0xff808080U);
      },
      link_.log);
  link_.patterns = &board;
  std::mutex mutex;
  std::vector<Pixels> taken;
  Screenshots screenshots(
      kSize,
      [&](const Screenshot& screenshot) {
        const std::lock_guard lock(mutex);
        taken.push_back(pixels_of(screenshot.frame.pixels()));
        return std::string("kept");
      },
      link_.log);
  link_.screenshots = &screenshots;
  const std::vector<std::vector<PlayerCommand>> states = {
      {},
      {{PlayerAction::kFadeOut, 600s}},
      {{PlayerAction::kBlackoutOff}, {PlayerAction::kTestPattern, {}, 1}},
      {{PlayerAction::kTestPattern}, {PlayerAction::kBlackout}},
      {{PlayerAction::kBlackoutOff}, {PlayerAction::kPause}}};
  std::set<Pixels> presented;
  std::size_t begun = 0;
  int asked = 0;
  const LoopCounts counts = play(show_, [&](int flip, const Pixels& pixels) {
    presented.insert(pixels);
    const std::lock_guard lock(mutex);
    if (begun == taken.size() && begun < states.size()) {
      for (const PlayerCommand& command : states[begun]) link_.commands.push(command);
      ++begun;
      asked = flip + 10;
    }
    if (asked > 0 && flip >= asked && (begun != 3 || board.laid() == 1)) {
      link_.commands.push({PlayerAction::kScreenshot});
      asked = 0;
    }
    return taken.size() < states.size();
  });
  ASSERT_EQ(taken.size(), states.size());
  for (std::size_t i = 0; i < taken.size(); ++i) EXPECT_TRUE(presented.contains(taken[i])) << i;
  EXPECT_EQ(taken[2].front(), 0xff808080U);
  EXPECT_EQ(taken[3].front(), 0xff000000U);
  EXPECT_EQ(counts.screenshots, 5);
  EXPECT_EQ(counts.frames_late, 0);
}

TEST_F(Overlay, AScreenshotOfAPausedShowIsTheFrameOfThatTimeInAFile) {
  TemporaryFolder folder;
  Screenshots screenshots(kSize, screenshot_writer(folder.path() / "screenshots", "demo"), link_.log);
  link_.screenshots = &screenshots;
  std::string file;
  play(show_, [&](int flip, const Pixels&) {
    if (flip == 29) link_.commands.push({PlayerAction::kPause});  // frame 29 stands
    if (flip == 40) link_.commands.push({PlayerAction::kScreenshot});
    for (const EventLog::Line& line : link_.log.lines()) {
      if (line.text.starts_with("screenshot: ")) file = line.text.substr(12);
    }
    return file.empty();
  });
  ASSERT_FALSE(file.empty());
  const std::string name = std::filesystem::path(file).filename();
  EXPECT_TRUE(name.starts_with("demo-cue-1-0.483s-")) << name;
  EXPECT_TRUE(name.ends_with("Z.png")) << name;
  const ImageBuffer read = read_still(file);
  ImageBuffer as_shown(PixelFormat::kXrgb8888, kSize);
  convert(read.pixels(), as_shown.pixels());
  EXPECT_EQ(pixels_of(as_shown.pixels()), frame_of(show_, nanoseconds(1s) * 29 / 60, pool_));
}

TEST_F(Overlay, AScreenshotThatCannotBeWrittenIsSaid) {
  TemporaryFolder folder;
  { std::ofstream(folder.path() / "screenshots") << "in the way"; }
  Screenshots screenshots(kSize, screenshot_writer(folder.path() / "screenshots", "demo"), link_.log);
  link_.screenshots = &screenshots;
  std::string said;
  play(show_, [&](int flip, const Pixels&) {
    if (flip == 2) link_.commands.push({PlayerAction::kScreenshot});
    for (const EventLog::Line& line : link_.log.lines()) {
      if (line.text.starts_with("screenshot: ")) said = line.text;
    }
    return said.empty();
  });
  EXPECT_NE(said.find("screenshots: "), std::string::npos) << said;
}

}  // namespace
}  // namespace cupola
