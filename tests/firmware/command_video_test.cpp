// Shows of video and of finished frames, through the program.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "pipeline/frame/still.h"
#include "tests/firmware/program.h"

namespace cupola {
namespace {

using testing::HasSubstr;

class Moving : public ProgramTest {
 protected:
  void show(const std::string& keys) const {
    write_text(folder_ / "show.toml", "rig = \"rig.toml\"\n[[cue]]\nname = \"a\"\n" + keys);
  }
  void render(const std::string& into) const {
    const Outcome outcome = call({"render", path("show.toml"), "--out", path(into)});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
  }
  nlohmann::json play(std::vector<std::string> more = {"--display", "fake", "--fast-forward"}) const {
    more.insert(more.begin(), {"play", path("show.toml"), "--stats", path("stats.json")});
    const Outcome outcome = call(more);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return nlohmann::json::parse(read_text(folder_ / "stats.json"));
  }
  static ImageBuffer face(int view, int number) {
    return noise_picture(PixelFormat::kRgbPlanar8, {48, 48}, static_cast<std::uint32_t>(10 * number + view));
  }
  void write_faces() const {
    const char* const names[] = {"front", "left", "right", "top"};
    for (int view = 0; view < 4; ++view) {
      for (int number = 1; number <= 5; ++number) {
        write_png(path(std::string(names[view]) + "_" + std::to_string(number) + ".png"),
                  face(view, number).pixels());
      }
    }
  }
};

TEST_F(Moving, FinishedFramesAreShownAsTheyAre) {
  std::vector<ImageBuffer> frames;
  for (int number = 1; number <= 4; ++number) {
    frames.push_back(noise_picture(PixelFormat::kRgb8, {96, 70}, static_cast<std::uint32_t>(number)));
    write_png(path("dome_" + std::to_string(number) + ".png"), frames.back().pixels());
  }
  show("source = \"sequence\"\nfile = \"dome_%d.png\"\nfinished = true\nrate = 60\n");
  render("out");
  play({"--display", "file", "--out", path("played")});
  EXPECT_EQ(play()["heap_allocations"], 0);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string name = "/show_00000" + std::to_string(i + 1) + ".png";
    EXPECT_EQ(largest_difference(read_still(path("out" + name)).pixels(), frames[i].pixels()), 0) << i;
    EXPECT_EQ(read_text(path("out" + name)), read_text(path("played" + name))) << i;
  }
  write_png(path("dome_1.png"), noise_picture(PixelFormat::kRgb8, {96, 71}, 1).pixels());
  for (const char* command : {"play", "check"}) {
    const Outcome outcome = call({command, path("show.toml")});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("96 x 71 pixels; expected 96 x 70, as the frame of "));
  }
}

TEST_F(Moving, FinishedFramesAndFacesFollowEachOther) {
  write_faces();
  write_png(path("dome.png"), noise_picture(PixelFormat::kRgb8, {96, 70}, 1).pixels());
  show(
      "source = \"stills\"\nfile = \"dome.png\"\nfinished = true\nduration_s = 0.1\n"
      "[[cue]]\nname = \"b\"\nsource = \"sequence\"\nfile = \"{view}_%d.png\"\nthen = \"c\"\n"
      "[[cue]]\nname = \"c\"\nsource = \"stills\"\nfile = \"dome.png\"\nfinished = true\nduration_s = 0.1\n");
  render("rendered.y4m");
  play({"--display", "file", "--out", path("played.y4m")});
  EXPECT_TRUE(read_text(path("rendered.y4m")) == read_text(path("played.y4m")));
}

// Two decoders at a time, and two warps: what the old cue shows goes on while the new one comes.
TEST_F(Moving, FadesBetweenFacesAndFinishedFramesArePlayedAsTheyAreRendered) {
  write_faces();
  for (int number = 1; number <= 6; ++number) {
    write_png(path("dome_" + std::to_string(number) + ".png"),
              noise_picture(PixelFormat::kRgb8, {96, 70}, static_cast<std::uint32_t>(number)).pixels());
  }
  const std::string fade = "transition = \"fade\"\nfade_s = 0.15\nloop = true\nduration_s = 0.4\n";
  show("source = \"sequence\"\nfile = \"dome_%d.png\"\nfinished = true\nrate = 30\n" + fade +
       "[[cue]]\nname = \"b\"\nsource = \"sequence\"\nfile = \"{view}_%d.png\"\nrate = 60\n" + fade +
       "[[cue]]\nname = \"c\"\nsource = \"sequence\"\nfile = \"dome_%d.png\"\nfinished = true\nrate = 60\n" +
       fade);
  render("rendered.y4m");
  play({"--display", "file", "--out", path("played.y4m")});
  EXPECT_TRUE(read_text(path("rendered.y4m")) == read_text(path("played.y4m")));
  const nlohmann::json counts = play();
  EXPECT_EQ(counts["frames_presented"], 72);
  EXPECT_EQ(counts["heap_allocations"], 0);
  EXPECT_EQ(play({"--display", "fake"})["heap_allocations"], 0) << "in real time, late as they may be";
}

#ifdef CUPOLA_VIDEO

void ffmpeg(const std::string& arguments) {
  ASSERT_EQ(std::system(("ffmpeg -nostdin -v error -y " + arguments).c_str()), 0) << arguments;
}

// Lossless videos of pictures give, to the bit, the frames that the pictures give.
TEST_F(Moving, VideosGiveTheFramesOfTheirPictures) {
  write_faces();
  show("source = \"sequence\"\nfile = \"{view}_%d.png\"\nrate = 25\n");
  render("sequence.y4m");
  std::string inputs;
  for (const char* view : {"front", "left", "right", "top"}) {
    const std::string input = "-framerate 25 -i " + path(view) + "_%d.png ";
    ffmpeg(input + "-c:v ffv1 " + path(view) + ".mkv");
    inputs += input;
  }
  const auto expect_same = [&](const std::string& keys) {
    show("source = \"video\"\n" + keys);
    render("video.y4m");
    EXPECT_TRUE(read_text(path("video.y4m")) == read_text(path("sequence.y4m"))) << keys;
    const nlohmann::json counts = play();
    EXPECT_EQ(counts["frames_presented"], 12) << keys;
    EXPECT_EQ(counts["frames_unchanged"], 7) << keys << "a video's own rate is 25";
    EXPECT_EQ(counts["heap_allocations"], 0) << keys;
  };
  expect_same("file = \"{view}.mkv\"\n");
  // FFmpeg's order: right, left, top; bottom, front, back.
  ffmpeg(inputs +
         "-filter_complex "
         "[2][1][3][3][0][0]xstack=inputs=6:layout=0_0\\|w0_0\\|w0+w0_0\\|0_h0\\|w0_h0\\|w0+w0_h0 "
         "-c:v ffv1 " +
         path("3x2.mkv"));
  expect_same("file = \"3x2.mkv\"\nlayout = \"3x2\"\n");
  ffmpeg(inputs + "-filter_complex [2][1][3][3][0][0]hstack=inputs=6 -c:v ffv1 " + path("6x1.mkv"));
  expect_same("file = \"6x1.mkv\"\nlayout = \"6x1\"\n");
  ffmpeg(inputs + "-filter_complex [0][1][2][3]hstack=inputs=4 -c:v ffv1 " + path("4x1.mkv"));
  expect_same("file = \"4x1.mkv\"\nlayout = \"4x1\"\n");
  ffmpeg(inputs +
         "-filter_complex "
         "[0]pad=54:54:3:3[a]\\;[1]pad=54:54:3:3[b]\\;[2]pad=54:54:3:3[c]\\;[3]pad=54:54:3:3[d]\\;"
         "[d][c][b][a]hstack=inputs=4 -c:v ffv1 " +
         path("padded.mkv"));
  expect_same(
      "file = \"padded.mkv\"\nlayout = \"4x1\"\nfaces = [\"top\", \"right\", \"left\", \"front\"]\npadding = "
      "3\n");
}

TEST_F(Moving, FinishedVideoIsShownAsItIs) {
  ffmpeg("-f lavfi -i testsrc2=s=96x70:r=60 -frames:v 12 -c:v ffv1 -pix_fmt bgr0 " + path("dome.mkv"));
  ffmpeg("-i " + path("dome.mkv") + " " + path("dome_%06d.png"));
  show("source = \"video\"\nfile = \"dome.mkv\"\nfinished = true\n");
  render("out");
  for (const char* number : {"000001", "000007", "000012"}) {
    EXPECT_EQ(largest_difference(read_still(path(std::string("out/show_") + number + ".png")).pixels(),
                                 read_still(path(std::string("dome_") + number + ".png")).pixels()),
              0);
  }
  show(
      "source = \"video\"\nfile = \"dome.mkv\"\nfinished = true\nin = 5\nout = 7\nloop = true\nduration_s = "
      "0.2\n");
  EXPECT_EQ(play()["frames_presented"], 12);
}

#endif

}  // namespace
}  // namespace cupola
