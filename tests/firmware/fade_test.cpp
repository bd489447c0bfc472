// Fades between cues: which frames are mixed, how much of each, and what becomes of the pixels.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "firmware/frame_mix.h"
#include "firmware/show_frames.h"
#include "pipeline/frame/error.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

std::optional<Fade> fade_of(Timeline& timeline, nanoseconds time) {
  timeline.at(time);
  return timeline.fade();
}

TEST(Fade, MovesWithTheFramesOfTheCueThatComes) {
  // A second at 10 Hz, then a second at 10 Hz whose first 4 frames are mixed.
  Timeline timeline(
      {{.rate = 10.0, .frames = 10, .then = 1}, {.rate = 10.0, .frames = 10, .fade_frames = 4}});
  EXPECT_EQ(fade_of(timeline, 900ms), std::nullopt);
  for (int step = 0; step < 4; ++step) {
    const auto weight = static_cast<std::int32_t>(std::lround(32768.0 * (step + 1) / 5.0));
    // The old cue is at its end: its last frame stands.
    const Fade expected{Moment{0, 9}, weight};
    EXPECT_EQ(fade_of(timeline, 1s + step * 100ms), expected) << step;
    EXPECT_EQ(fade_of(timeline, 1s + step * 100ms + 40ms), expected) << "a flip that comes a little late";
  }
  EXPECT_EQ(fade_of(timeline, 1400ms), std::nullopt);
}

TEST(Fade, LetsTheOldCueGoOnWhereItHasFrames) {
  Timeline timeline({{.rate = 10.0, .frames = 100, .duration = 1s, .then = 1},
                     {.rate = 10.0, .then = 2, .fade_frames = 4},
                     {.rate = 10.0, .fade_frames = 4}});
  timeline.at(0s);
  EXPECT_EQ(fade_of(timeline, 1200ms)->from, (Moment{0, 12}));
  timeline.next_cue(2s);
  EXPECT_EQ(fade_of(timeline, 2100ms)->from, (Moment{1, 11}));
}

TEST(Fade, LeavesACueThatWaitedAsItStood) {
  Timeline timeline({{.rate = 10.0, .frames = 100, .duration = 1s, .then = 1, .wait = true},
                     {.rate = 10.0, .fade_frames = 4}});
  EXPECT_EQ(timeline.at(5s), (Moment{0, 9}));
  timeline.go(5s);
  EXPECT_EQ(fade_of(timeline, 5200ms)->from, (Moment{0, 9}));
}

TEST(Fade, OfTheFirstCueComesOutOfBlack) {
  Timeline timeline({{.rate = 10.0, .fade_frames = 4}});
  ASSERT_TRUE(fade_of(timeline, 0s));
  EXPECT_EQ(timeline.fade()->from, std::nullopt);
  EXPECT_EQ(fade_of(timeline, 400ms), std::nullopt);
}

TEST(Fade, EndsWithASeekAndIsNotIntoTheSameCue) {
  Timeline timeline({{.rate = 10.0}, {.rate = 10.0, .fade_frames = 40}});
  timeline.at(0s);
  timeline.jump(1, 1s);
  EXPECT_TRUE(fade_of(timeline, 1100ms));
  timeline.seek(1s, 1200ms);
  EXPECT_EQ(fade_of(timeline, 1200ms), std::nullopt);
  timeline.jump(1, 2s);
  EXPECT_EQ(fade_of(timeline, 2100ms), std::nullopt);
}

// Two cues of half a second at 60 Hz; 12 frames of fade.
Show small_show(const std::string& transition) {
  const std::string lines[] = {
      "rig.frame.width=64", "rig.frame.height=48", "rig.frame.center=[32, 24]", "rig.frame.radius=30",
      R"(cue=[{name="a", source="generated", world="demo", face_size=[32, 32], duration_s=0.5},)"
      R"({name="b", source="generated", world="grid", face_size=[32, 32], duration_s=0.5)" +
          transition + "}]"};
  return load_show("demo", lines);
}

nanoseconds time_of(std::int64_t frame) {
  return nanoseconds(std::llround(1e9 * static_cast<double>(frame) / 60.0));
}

class FadedShow : public testing::Test {
 protected:
  ImageBuffer frame(ShowFrames& frames, std::int64_t number, PixelFormat format) {
    ImageBuffer image(format, {64, 48});
    EXPECT_NE(frames.advance({time_of(number), time_of(number)}), FrameMaker::Change::kFailed);
    frames.warp(image.pixels(), 0);
    return image;
  }
  ShowFrames make(const std::string& transition) {
    return ShowFrames(small_show(transition), Method::kEwa, Cpu::kScalar, pool_);
  }
  WorkerPool pool_{2};
};

void expect_same(const ImageBuffer& a, const ImageBuffer& b, std::int64_t number) {
  for (int p = 0; p < plane_count(a.format()); ++p) {
    for (int y = 0; y < a.size().height; ++y) {
      ASSERT_EQ(std::memcmp(a.pixels().planes[static_cast<std::size_t>(p)].row(y),
                            b.pixels().planes[static_cast<std::size_t>(p)].row(y),
                            static_cast<std::size_t>(a.size().width * pixel_step(a.format()))),
                0)
          << "frame " << number << ", row " << y;
    }
  }
}

TEST_F(FadedShow, ShowsTheRoundedMeanOfBothCuesFrames) {
  ShowFrames faded = make(R"(, transition="fade", fade_s=0.2)");
  // The old cue alone, for longer; the new one alone, cut.
  const std::string on[] = {"rig.frame.width=64", "rig.frame.height=48", "rig.frame.center=[32, 24]",
                            "rig.frame.radius=30", "cue.0.face_size=[32, 32]"};
  ShowFrames old_cue(load_show("demo", on), Method::kEwa, Cpu::kScalar, pool_);
  ShowFrames cut = make("");
  for (const PixelFormat format : {PixelFormat::kXrgb8888}) {
    for (std::int64_t number = 0; number < 60; ++number) {
      const ImageBuffer is = frame(faded, number, format);
      const ImageBuffer b = frame(cut, number, format);
      const ImageBuffer a = frame(old_cue, number, format);
      if (number < 30 || number >= 42) {
        expect_same(is, b, number);
        continue;
      }
      const double share = std::round(32768.0 * static_cast<double>(number - 29) / 13.0) / 32768.0;
      ImageBuffer expected(format, {64, 48});
      for (int y = 0; y < 48; ++y) {
        for (int x = 0; x < 64 * 4; ++x) {
          expected.pixels().samples<std::uint8_t>(0, y)[x] =
              static_cast<std::uint8_t>(std::floor((1.0 - share) * a.pixels().samples<std::uint8_t>(0, y)[x] +
                                                   share * b.pixels().samples<std::uint8_t>(0, y)[x] + 0.5));
        }
      }
      expect_same(is, expected, number);
    }
  }
}

// With buffers of every age, and other commands between: what is mixed never shines through afterwards.
TEST_F(FadedShow, LeavesNothingBehindInBuffersThatAreUsedAgain) {
  ShowFrames faded = make(R"(, transition="fade", fade_s=0.2)");
  ShowFrames again = make(R"(, transition="fade", fade_s=0.2)");
  ImageBuffer buffers[3] = {{PixelFormat::kXrgb8888, {64, 48}},
                            {PixelFormat::kXrgb8888, {64, 48}},
                            {PixelFormat::kXrgb8888, {64, 48}}};
  int presented = 0;
  for (std::int64_t number = 0; number < 60; ++number) {
    const FrameMaker::Change change = faded.advance({time_of(number), time_of(number)});
    const ImageBuffer whole = frame(again, number, PixelFormat::kXrgb8888);
    if (change != FrameMaker::Change::kNew) continue;
    ImageBuffer& buffer = buffers[presented % 3];
    faded.warp(buffer.pixels(), presented < 3 ? 0 : 3);
    ++presented;
    expect_same(buffer, whole, number);
  }
  EXPECT_GT(presented, 40);
}

// Twice cut short: from what was seen, which stands, not from the cue that was only coming.
TEST_F(FadedShow, GoesOnFromWhatIsSeenWhereItIsCutShort) {
  const std::string lines[] = {
      "rig.frame.width=64", "rig.frame.height=48", "rig.frame.center=[32, 24]", "rig.frame.radius=30",
      R"(cue=[{name="a", source="generated", world="demo", face_size=[32, 32], duration_s=0.5},)"
      R"({name="b", source="generated", world="grid", face_size=[32, 32], transition="fade", fade_s=0.5},)"
      R"({name="c", source="generated", world="demo", face_size=[24, 24], transition="fade", fade_s=0.5}])"};
  ShowFrames show(load_show("demo", lines), Method::kEwa, Cpu::kScalar, pool_);
  for (std::int64_t number = 0; number < 45; ++number) frame(show, number, PixelFormat::kXrgb8888);
  std::int64_t number = 45;
  for (const std::size_t to : {2, 1, 0}) {  // the last one is a cut
    const ImageBuffer seen = frame(show, number - 1, PixelFormat::kXrgb8888);
    ShowFrames cut(load_show("demo", lines), Method::kEwa, Cpu::kScalar, pool_);
    cut.begin_in(to, nanoseconds(0));
    const std::int64_t begin = number;
    for (; number < begin + 7; ++number) {
      const PlayerCommand command{PlayerAction::kCue, nanoseconds(0), to};
      const bool now = number == begin;
      show.advance({time_of(number), time_of(number), {&command, now ? std::size_t{1} : 0}});
      ImageBuffer is(PixelFormat::kXrgb8888, {64, 48});
      show.warp(is.pixels(), 0);
      const ImageBuffer coming = frame(cut, number - begin, PixelFormat::kXrgb8888);
      if (to == 0) {
        expect_same(is, coming, number);
        continue;
      }
      const double share = std::round(32768.0 * static_cast<double>(number - begin + 1) / 31.0) / 32768.0;
      ImageBuffer expected(PixelFormat::kXrgb8888, {64, 48});
      for (int y = 0; y < 48; ++y) {
        const auto* a = seen.pixels().samples<std::uint8_t>(0, y);
        const auto* b = coming.pixels().samples<std::uint8_t>(0, y);
        for (int x = 0; x < 64 * 4; ++x) {
          expected.pixels().samples<std::uint8_t>(0, y)[x] =
              static_cast<std::uint8_t>(std::floor((1.0 - share) * a[x] + share * b[x] + 0.5));
        }
      }
      expect_same(is, expected, number);
    }
  }
}

TEST_F(FadedShow, IsRefusedWhereItIsLongerThanTheCue) {
  try {
    make(R"(, transition="fade", fade_s=0.6)");
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("fade_s: expected at most the cue's duration_s, 0.5"));
  }
  EXPECT_THROW(make(R"(, transition="fade")"), InputError);
  EXPECT_THROW(make(R"(, fade_s=0.1)"), InputError) << "of a cut";
  EXPECT_THROW(make(R"(, transition="dissolve", fade_s=0.1)"), InputError);
}

}  // namespace
}  // namespace cupola
