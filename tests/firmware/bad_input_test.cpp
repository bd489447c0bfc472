// Inputs that are wrong: the program names the file and the reason, and leaves nothing behind.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "tests/firmware/program.h"

namespace cupola {
namespace {

using testing::HasSubstr;

class BadPicture : public ProgramTest {
 protected:
  // Both commands that read pictures, with `bytes` as the front view.
  void expect_refused(std::string_view bytes, const std::vector<std::string>& reasons) const {
    write_text(folder_ / "front.png", bytes);
    std::vector<std::string> words = {path("front.png")};
    words.insert(words.end(), reasons.begin(), reasons.end());
    expect_refusal(warp_arguments(), 2, words);
    std::vector<std::string> render = warp_arguments();
    render[0] = "render";
    render[4] = path("frames");
    expect_refusal(render, 2, words);
  }
};

TEST_F(BadPicture, Missing) {
  std::filesystem::remove(path("front.png"));
  expect_refusal(warp_arguments(), 2, {path("front.png"), "No such file"});
}

TEST_F(BadPicture, Folder) {
  std::filesystem::remove(path("front.png"));
  std::filesystem::create_directory(path("front.png"));
  expect_refusal(warp_arguments(), 2, {path("front.png")});
}

TEST_F(BadPicture, Empty) {
  expect_refused("", {});
}

TEST_F(BadPicture, Garbage) {
  expect_refused(std::string(5000, '\x7f'), {});
}

TEST_F(BadPicture, Truncated) {
  const std::string whole = read_text(path("front.png"));
  for (const std::size_t bytes : {std::size_t{7}, std::size_t{20}, whole.size() / 2, whole.size() - 30}) {
    expect_refused(std::string_view(whole).substr(0, bytes), {});
  }
}

TEST_F(BadPicture, TruncatedJpeg) {
  const std::string whole = jpeg_file(smooth_picture(PixelFormat::kRgb8, {48, 48}).pixels());
  expect_refused(whole.substr(0, whole.size() / 2), {});
}

TEST_F(BadPicture, OfAnotherSizeThanTheRigDemands) {
  write_rig("rig.toml", "name = \"front\"", "name = \"front\"\nsize = [64, 32]");
  expect_refusal(warp_arguments(), 2, {path("front.png"), path("rig.toml"), "48 x 48", "64 x 32"});
}

TEST_F(BadPicture, OfZeroSize) {
  expect_refused(kPngSignature + png_header(0, 0, 8, 2) + png_data("") + kPngEnd, {});
}

TEST_F(BadPicture, TooWide) {
  expect_refused(
      kPngSignature + png_header(65536, 2, 8, 2) + png_data(std::string(2 * (1 + 3 * 65536), '\0')) + kPngEnd,
      {"65536"});
}

TEST_F(BadPicture, Animated) {
  const ImageBuffer picture = smooth_picture(PixelFormat::kRgbPlanar8, {48, 48});
  expect_refused(png_file(picture.pixels(), false, png_chunk("acTL", std::string("\0\0\0\2\0\0\0\0", 8))),
                 {"animated"});
}

TEST_F(BadPicture, CmykJpeg) {
  const ImageBuffer picture = smooth_picture(PixelFormat::kRgbPlanar8, {48, 48});
  expect_refused(jpeg_file(picture.pixels(), {.components = 4}), {"CMYK"});
  expect_refused(jpeg_file(picture.pixels(), {.components = 4, .ycck = true}), {"YCCK"});
}

using BadViews = ProgramTest;

TEST_F(BadViews, GivenTwice) {
  expect_refusal(warp_arguments({"--view", "front=" + path("left.png")}), 2,
                 {"--view front=" + path("left.png"), "given before"});
}

TEST_F(BadViews, Unknown) {
  expect_refusal(warp_arguments({"--view", "lefd=" + path("left.png")}), 2,
                 {"--view lefd=", path("rig.toml"), "no view lefd", "did you mean left?"});
}

TEST_F(BadViews, LeftOut) {
  expect_refusal(
      {"warp", "--rig", path("rig.toml"), "--view", "front=" + path("front.png"), "--out", path("frame.png")},
      2, {"--view left=IMG: missing", path("rig.toml")});
}

TEST_F(BadViews, WithoutAPicture) {
  expect_refusal(warp_arguments({"--view", "front"}), 2, {"--view front: expected NAME=IMG"});
}

TEST_F(BadViews, AndAnAtlasAtOnce) {
  expect_refusal(warp_arguments({"--atlas", path("front.png"), "--layout", "1x1", "--faces", "front"}), 2,
                 {"--atlas"});
}

TEST_F(BadViews, NotInTheAtlas) {
  const std::vector<std::string> start = {
      "warp", "--rig", path("rig.toml"), "--out", path("frame.png"), "--atlas", path("front.png")};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), start.begin(), start.end());
    return more;
  };
  expect_refusal(with({"--layout", "2x2", "--faces", "front,left,right,bottom"}), 2,
                 {path("front.png"), "top"});
  expect_refusal(with({"--layout", "2x2", "--faces", "front,left,right,front"}), 2,
                 {path("front.png"), "front"});
  expect_refusal(with({"--layout", "5x1", "--faces", "front,left,right,top,back"}), 2,
                 {path("front.png"), "48 x 48"});
  expect_refusal(with({"--layout", "2", "--faces", "front"}), 2, {"--layout 2", "like 3x2"});
  expect_refusal(with({"--layout", "1x1", "--faces", "front,left"}), 2, {"--layout 1x1", "too many"});
  expect_refusal(with({"--layout", "2x2"}), 2, {"--faces"});
}

class BadRig : public ProgramTest {
 protected:
  void expect_refused(std::string_view replaced, std::string_view replacement,
                      const std::vector<std::string>& reasons) {
    write_rig("bad.toml", replaced, replacement);
    std::vector<std::string> words = {path("bad.toml")};
    words.insert(words.end(), reasons.begin(), reasons.end());
    std::vector<std::string> warp = warp_arguments();
    warp[2] = path("bad.toml");
    expect_refusal(warp, 2, words);
    expect_refusal({"check", "--rig", path("bad.toml")}, 2, words);
    expect_refusal({"table", "--rig", path("bad.toml")}, 2, words);
  }
};

TEST_F(BadRig, Missing) {
  expect_refusal({"check", "--rig", path("none.toml")}, 2, {path("none.toml"), "No such file"});
}

TEST_F(BadRig, NoToml) {
  expect_refused("[frame]", "[frame", {"bad.toml:3: "});
}

TEST_F(BadRig, NotANumber) {
  expect_refused("radius = 48.0", "radius = nan", {"bad.toml:7: frame.radius: expected a number", "not nan"});
  expect_refused("radius = 48.0", "radius = -inf",
                 {"bad.toml:7: frame.radius: expected a number", "not -inf"});
}

TEST_F(BadRig, OfNoSize) {
  expect_refused("width = 96", "width = 0", {"bad.toml:4: frame.width: expected a whole number from 1"});
  expect_refused("width = 96", "width = 1000000", {"bad.toml:4: frame.width"});
}

TEST_F(BadRig, FoldingLens) {
  expect_refused("model = \"omnimax-c430\"", "model = \"polynomial\"\ncoefficients = [0.0, 1.5, -2.0]",
                 {"lens"});
}

TEST_F(BadRig, SingularView) {
  expect_refused("name = \"left\"", "name = \"odd\"\nforward = [0, 1, 0]\nup = [0, 2, 0]",
                 {"view.1.up", "parallel to forward"});
  expect_refused("name = \"left\"", "name = \"odd\"\nforward = [0, 0, 0]\nup = [0, 1, 0]",
                 {"view.1.forward"});
}

TEST_F(BadRig, ViewsOfOneName) {
  expect_refused("name = \"left\"", "name = \"front\"", {"bad.toml:16: view.1.name", "front already"});
}

TEST_F(BadRig, UnknownKeys) {
  expect_refused("[lens]", "[lense]\n[lens]", {"bad.toml:9: lense: unknown key; did you mean lens?"});
  expect_refused("radius = 48.0", "radius = 48.0\nradios = 48.0",
                 {"frame.radios: unknown key; did you mean radius?"});
}

class BadShow : public ProgramTest {
 protected:
  static constexpr std::string_view kShow = R"(rig = "rig.toml"

[[cue]]
name = "a"
source = "stills"
file = "{view}.png"
duration_s = 1

[[cue]]
name = "b"
source = "generated"
world = "demo"
face_size = [32, 32]
duration_s = 1
)";
  void expect_refused(std::string_view replaced, std::string_view replacement,
                      const std::vector<std::string>& words) {
    std::string text(kShow);
    const std::size_t at = text.find(replaced);
    ASSERT_NE(at, std::string::npos) << replaced;
    text.replace(at, replaced.size(), replacement);
    write_text(folder_ / "show.toml", text);
    expect_refusal({"check", path("show.toml")}, 2, words);
    expect_refusal({"render", path("show.toml"), "--out", path("frames")}, 2, words);
    expect_refusal({"play", path("show.toml"), "--display", "fake"}, 2, words);
  }
};

TEST_F(BadShow, IsFineAsItStands) {
  write_text(folder_ / "show.toml", kShow);
  const Outcome outcome = call({"check", path("show.toml")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, testing::EndsWith("ok\n"));
}

TEST_F(BadShow, Missing) {
  expect_refusal({"check", path("none.toml")}, 2, {path("none.toml"), "No such file"});
}

TEST_F(BadShow, OfSourcesOfLaterVersions) {
  for (const char* source : {"scene", "composite", "multiprojection"}) {
    expect_refused("\"stills\"", std::string("\"") + source + "\"",
                   {"show.toml:5: cue.0.source: ", source, "not part of this version"});
  }
}

TEST_F(BadShow, WithWrongValues) {
  expect_refused("\"stills\"", "\"stils\"", {"show.toml:5: cue.0.source", "did you mean stills?"});
  expect_refused("duration_s = 1", "duration_s = 1\ntransition = \"fade\"", {"cue.0.fade_s: missing"});
  expect_refused("duration_s = 1", "duration_s = nan", {"cue.0.duration_s: expected a number"});
  expect_refused("duration_s = 1", "duration_s = 1\nthen = \"nxt\"", {"cue.0.then", "did you mean next?"});
  expect_refused("name = \"b\"", "name = \"a\"", {"show.toml:10: cue.1.name", "is taken"});
  expect_refused("\"demo\"", "\"demmo\"", {"cue.1.world", "did you mean demo?"});
  expect_refused("[32, 32]", "[32, 0]", {"cue.1.face_size"});
  expect_refused("\"rig.toml\"", "\"reg.toml\"", {"reg.toml", "No such file"});
  expect_refused("{view}.png", "{view}.jpg", {"front.jpg", "No such file"});
  expect_refused("duration_s = 1", "durations_s = 1",
                 {"cue.0.durations_s: unknown key; did you mean duration_s?"});
}

TEST_F(BadShow, WithLayoutsThatDoNotFit) {
  const auto video = [&](const std::string& keys, const std::vector<std::string>& words) {
    write_text(folder_ / "show.toml",
               "rig = \"rig.toml\"\n[[cue]]\nname = \"a\"\nsource = \"video\"\n" + keys);
    expect_refusal({"play", path("show.toml"), "--display", "fake"}, 2, words);
  };
  video("file = \"v.mp4\"\n", {"show.toml:5: cue.0.file", "{view}", "layout", "finished"});
  video("file = \"v.mp4\"\nlayout = \"3\"\n", {"show.toml:6: cue.0.layout", "3x2"});
  video("file = \"v.mp4\"\nlayout = \"5x1\"\n", {"cue.0.faces: missing"});
  video("file = \"v.mp4\"\nlayout = \"3x2\"\npadding = -1\n", {"show.toml:7: cue.0.padding"});
  video("file = \"{view}.mp4\"\nlayout = \"3x2\"\n", {"cue.0.layout", "every view has a file"});
  video("file = \"v.mp4\"\nfinished = true\nlayout = \"3x2\"\n", {"cue.0.layout", "finished"});
  video("file = \"v.mp4\"\nfinished = true\ncompare = \"nearest\"\n", {"cue.0.compare", "finished"});
#ifdef CUPOLA_VIDEO
  video("file = \"v.mp4\"\nlayout = \"3x2\"\n", {"v.mp4: No such file"});
  video("file = \"front.png\"\nlayout = \"3x2\"\n", {"front.png: not a video that can be read"});
#endif
}

TEST_F(BadShow, WhoseLastFrameIsBroken) {
  const auto file = [&](const std::string& view, int number) {
    return path(view + "_" + std::to_string(number) + ".png");
  };
  for (const std::string view : {"front", "left", "right", "top"}) {
    for (int number = 1; number <= 4; ++number)

      write_text(file(view, number), png_file(noise_picture(PixelFormat::kRgbPlanar8, {128, 128}).pixels()));
  }
  write_text(folder_ / "show.toml",
             "rig = \"rig.toml\"\n[[cue]]\nname = \"a\"\nsource = \"sequence\"\nfile = \"{view}_%d.png\"\n");
  const Outcome good = call({"check", path("show.toml")});
  EXPECT_NE(good.code, 2) << good.err;
  EXPECT_THAT(good.out + good.err, HasSubstr("cue a: 4 frames, 60 a second; decode "));

  const std::string whole = read_text(file("left", 4));
  write_text(file("left", 4), std::string_view(whole).substr(0, whole.size() - 2000));  // the header is there
  expect_refusal({"check", path("show.toml")}, 2, {"cue a: frame 3: ", file("left", 4)});
  write_text(file("left", 4), whole);

  write_text(file("top", 2), png_file(smooth_picture(PixelFormat::kRgbPlanar8, {40, 48}).pixels()));
  write_text(file("top", 3), "no picture");
  const Outcome wrong = call({"check", path("show.toml")});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr(file("top", 2) + ": the picture is 40 x 48; expected 128 x 128"));
  EXPECT_THAT(wrong.err, HasSubstr(file("top", 3) + ": not a picture"));

  std::filesystem::remove(file("top", 3));
  std::filesystem::remove(file("right", 2));
  std::filesystem::remove(file("right", 3));
  expect_refusal({"check", path("show.toml")}, 2,
                 {"right_2.png: missing", "right_%d.png lacks 2 to 3", "top_%d.png lacks 3"});
}

TEST_F(BadShow, ThatThisMachineCannotHold) {
  std::string text(kShow);
  text.replace(text.find("duration_s = 1\n", text.find("\"b\"")), 15, "duration_s = 1\nrate = 1000\n");
  text.replace(text.find("[32, 32]"), 8, "[1024, 1024]");
  write_text(folder_ / "show.toml", text);
  const Outcome outcome = call({"check", path("show.toml"), "--threads", "1"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("cue b: 1 s, 1000 a second; faces "));
  EXPECT_THAT(outcome.err, HasSubstr("; does not hold: at most "));
}

TEST_F(BadShow, IsCheckedToTheEnd) {
  write_text(folder_ / "show.toml", R"(rig = "none.toml"
extra = 1
[[cue]]
name = "a"
source = "scene"
[[cue]]
name = "b"
source = "generated"
world = "nowhere"
[[cue]]
name = "c"
source = "generated"
world = "demo"
speed = 3
)");
  const Outcome outcome = call({"check", path("show.toml")});
  EXPECT_EQ(outcome.code, 2);
  for (const char* reason : {"none.toml", "extra: unknown key", "cue.0.source: scene is not part",
                             "cue.1.world", "cue.2.speed: unknown key"}) {
    EXPECT_THAT(outcome.err, HasSubstr(reason));
  }
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 5) << outcome.err;
}

}  // namespace
}  // namespace cupola
