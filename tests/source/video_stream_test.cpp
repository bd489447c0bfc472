// Compressed videos: every frame of them, in whatever order, to the bit. FFmpeg's program makes them.
// SPDX-License-Identifier: MIT
#include "pipeline/source/video_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "pipeline/frame/error.h"
#include "pipeline/frame/still.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using testing::HasSubstr;

constexpr Size kSize{80, 48};

void ffmpeg(const std::string& arguments) {
  ASSERT_EQ(std::system(("ffmpeg -nostdin -v error -y " + arguments).c_str()), 0) << arguments;
}

template <class Call>
std::string refusal(Call call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

ImageBuffer frame_of(PictureStream& video, std::int64_t frame) {
  ImageBuffer image(PixelFormat::kRgbPlanar8, video.size());
  EXPECT_TRUE(video.read(frame, {}, image.pixels(), true));
  return image;
}

struct Kind {
  const char* name;
  const char* file;
  const char* options;
};
void PrintTo(const Kind& kind, std::ostream* out) {
  *out << kind.name;
}

class EveryVideo : public testing::TestWithParam<Kind> {};

TEST_P(EveryVideo, GivesAFrameToTheBitWhateverWasReadBefore) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / GetParam().file;
  ffmpeg("-f lavfi -i testsrc2=s=80x48:r=25:d=2.4,noise=alls=60:allf=t -frames:v 60 " +
         std::string(GetParam().options) + " " + file.string());
  const auto in_order = open_video(file);
  ASSERT_EQ(in_order->length(), 60);
  EXPECT_EQ(in_order->size(), kSize);
  EXPECT_NEAR(in_order->rate(), 25.0, 1e-6);
  std::vector<ImageBuffer> frames;
  for (int frame = 0; frame < 60; ++frame) frames.push_back(frame_of(*in_order, frame));
  for (int frame = 1; frame < 60; ++frame)
    EXPECT_GT(largest_difference(frames[static_cast<std::size_t>(frame - 1)].pixels(),
                                 frames[static_cast<std::size_t>(frame)].pixels()),
              8)
        << "frame " << frame << " is one of its own";
  const auto sought = open_video(file);
  for (const int frame : {37, 36, 59, 0, 13, 14, 16, 12, 59, 58, 1, 1, 30, 29, 31, 25, 24, 50, 49, 2}) {
    const ImageBuffer image = frame_of(*sought, frame);
    EXPECT_EQ(largest_difference(image.pixels(), frames[static_cast<std::size_t>(frame)].pixels()), 0)
        << frame;
  }
  for (int frame = 59; frame >= 0; --frame) {
    const ImageBuffer image = frame_of(*sought, frame);
    ASSERT_EQ(largest_difference(image.pixels(), frames[static_cast<std::size_t>(frame)].pixels()), 0)
        << frame;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, EveryVideo,
    testing::Values(Kind{"H264WithBFrames", "v.mp4", "-c:v libx264 -bf 3 -g 12 -pix_fmt yuv420p"},
                    Kind{"H264WithOpenGroups", "v.mkv",
                         "-c:v libx264 -bf 3 -x264-params keyint=12:open-gop=1:bframes=3 -pix_fmt yuv420p"},
                    Kind{"H264OfOneKeyFrame", "v.mov",
                         "-c:v libx264 -bf 2 -g 1000 -sc_threshold 0 -pix_fmt yuv420p"},
                    Kind{"H264OfTenBits", "v.mkv", "-c:v libx264 -bf 3 -g 12 -pix_fmt yuv420p10le"},
                    Kind{"H264InTransportStream", "v.ts", "-c:v libx264 -bf 3 -g 12 -pix_fmt yuv420p"},
                    Kind{"Mjpeg", "v.mov", "-c:v mjpeg -q:v 3 -pix_fmt yuvj422p"},
                    Kind{"MjpegInAvi", "v.avi", "-c:v mjpeg -q:v 3 -pix_fmt yuvj420p"},
                    Kind{"Ffv1", "v.mkv", "-c:v ffv1 -level 3 -pix_fmt yuv444p"},
                    Kind{"Ffv1OfSixteenBits", "v.mkv", "-c:v ffv1 -level 3 -pix_fmt yuv422p16le"},
                    Kind{"Prores", "v.mov", "-c:v prores_ks -pix_fmt yuv422p10le"}),
    [](const auto& parameter) { return std::string(parameter.param.name); });

TEST(Video, HoldsThePicturesThatWentIn) {
  const TemporaryFolder folder;
  std::vector<ImageBuffer> pictures;
  for (int i = 1; i <= 3; ++i) {
    pictures.push_back(noise_picture(PixelFormat::kRgbPlanar8, kSize, static_cast<std::uint32_t>(i)));
    write_png(folder / ("p" + std::to_string(i) + ".png"), pictures.back().pixels());
  }
  const std::string in = "-framerate 30 -i " + (folder / "p%d.png").string();
  for (const char* kind : {"-c:v ffv1 -pix_fmt bgr0", "-c:v rawvideo -pix_fmt rgb24",
                           "-c:v rawvideo -pix_fmt gbrp", "-c:v png -pix_fmt rgba"}) {
    ffmpeg(in + " " + kind + " " + (folder / "rgb.nut").string());
    const auto video = open_video(folder / "rgb.nut");
    EXPECT_NEAR(video->rate(), 30.0, 1e-6);
    for (std::size_t i = 0; i < 3; ++i) {
      const ImageBuffer frame = frame_of(*video, static_cast<std::int64_t>(i));
      EXPECT_EQ(largest_difference(frame.pixels(), pictures[i].pixels()), 0) << kind;
    }
  }
}

// Lossless luma and chroma of even pictures, by every matrix and range: back to what they were but for the
// rounding of what was stored.
TEST(Video, TakesMatrixAndRangeFromTheStream) {
  const TemporaryFolder folder;
  for (const char* matrix : {"bt709", "bt601", "bt2020"}) {
    for (const char* range : {"tv", "pc"}) {
      for (const char* pixels : {"yuv444p", "yuv420p10le"}) {
        const std::string file = (folder / (std::string(matrix) + range + pixels + ".mkv")).string();
        const std::string space = matrix == std::string("bt601")    ? "smpte170m"
                                  : matrix == std::string("bt2020") ? "bt2020nc"
                                                                    : matrix;
        ffmpeg(
            "-f lavfi -i color=c=0xc83c1e:s=80x48:r=25,format=gbrp -frames:v 2 -vf scale=out_color_matrix=" +
            std::string(matrix) + ":out_range=" + range + ",format=" + pixels + " -colorspace " + space +
            " -color_range " + range + " -c:v ffv1 " + file);
        const ImageBuffer frame = frame_of(*open_video(file), 1);
        const int expected[] = {0xc8, 0x3c, 0x1e};
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(sample(frame, c, 40, 20), expected[c], 2) << file << " " << c;
      }
    }
  }
}

TEST(Video, TakesChromaByTurns) {
  const TemporaryFolder folder;
  const std::string made = (folder / "made.nut").string();
  ffmpeg(
      "-f lavfi -i testsrc2=s=81x49:r=25,noise=alls=60:allf=t -frames:v 3 -c:v rawvideo -pix_fmt yuv420p " +
      made);
  const auto expected = open_video(made);
  for (const std::string by_turns : {"nv12", "nv21"}) {
    const std::string other = (folder / (by_turns + ".nut")).string();
    ffmpeg("-i " + made + " -c:v rawvideo -pix_fmt " + by_turns + " " + other);
    const auto video = open_video(other);
    for (int frame = 0; frame < 3; ++frame) {
      EXPECT_EQ(largest_difference(frame_of(*video, frame).pixels(), frame_of(*expected, frame).pixels()), 0)
          << by_turns;
    }
  }
}

TEST(Video, NamesFramesThatAreBrokenAndGoesOn) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "v.avi";
  ffmpeg("-f lavfi -i testsrc2=s=80x48:r=25 -frames:v 20 -c:v mjpeg -q:v 3 " + file.string());
  const auto whole = open_video(file);
  const ImageBuffer after = frame_of(*whole, 12);
  std::string bytes = read_text(file);
  // The eighth JPEG's start is blotted out.
  std::size_t at = 0;
  for (int i = 0; i < 8; ++i) at = bytes.find("\xff\xd8\xff", at + 1);
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at, 700, 700, '\0');
  write_text(file, bytes);
  const auto video = open_video(file);
  ASSERT_EQ(video->length(), 20);
  for (int turn = 0; turn < 2; ++turn) {
    EXPECT_THAT(refusal([&] { frame_of(*video, 7); }), HasSubstr("v.avi: frame 7 "));
    EXPECT_EQ(refusal([&] { frame_of(*video, 8); }), "taken");
    EXPECT_EQ(largest_difference(frame_of(*video, 12).pixels(), after.pixels()), 0);
    EXPECT_EQ(refusal([&] { frame_of(*video, 6); }), "taken");
  }
}

TEST(Video, RefusesWhatIsNone) {
  const TemporaryFolder folder;
  const auto refused = [&](const char* name) { return refusal([&] { open_video(folder / name); }); };
  EXPECT_THAT(refused("none.mp4"), HasSubstr("none.mp4: No such file or directory; expected a video"));
  EXPECT_THAT(refusal([&] { open_video(folder.path()); }), HasSubstr("is a folder"));
  write_text(folder / "text.mp4", "no video at all");
  EXPECT_THAT(refused("text.mp4"), HasSubstr("text.mp4: not a video that can be read"));
  ffmpeg("-f lavfi -i sine=d=1 " + (folder / "sound.mka").string());
  EXPECT_THAT(refused("sound.mka"), HasSubstr("sound.mka: holds no video"));
  ffmpeg("-f lavfi -i testsrc2=s=80x48:r=25 -frames:v 5 -c:v ffv1 " + (folder / "v.mkv").string());
  write_text(folder / "list.m3u8", "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nv.mkv\n#EXT-X-ENDLIST\n");
  EXPECT_THAT(refused("list.m3u8"), HasSubstr("list.m3u8: not a video that can be read"));
  write_text(folder / "list.txt", "ffconcat version 1.0\nfile v.mkv\n");
  EXPECT_THAT(refused("list.txt"), HasSubstr("not a video that can be read"));
  write_text(folder / "short.mkv", read_text(folder / "v.mkv").substr(0, 300));
  EXPECT_THAT(refused("short.mkv"), HasSubstr("short.mkv: "));
  ffmpeg("-f lavfi -i testsrc2=s=80x48:r=25 -frames:v 5 -c:v rawvideo -pix_fmt rgb48be " +
         (folder / "rgb.nut").string());
  EXPECT_THAT(refused("rgb.nut"), HasSubstr("its pixels are rgb48be; expected 4:2:0"));
}

TEST(Video, ConvertsOnlyTheRowsAskedFor) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "v.mkv";
  ffmpeg("-f lavfi -i testsrc2=s=80x48:r=25 -frames:v 3 -c:v ffv1 -pix_fmt yuv420p " + file.string());
  const auto video = open_video(file);
  const ImageBuffer whole = frame_of(*video, 1);
  ImageBuffer part(PixelFormat::kRgbPlanar8, kSize);
  video->read(1, {11, 21}, part.pixels(), false);
  for (int x = 0; x < 80; ++x) {
    for (int y = 11; y < 21; ++y) ASSERT_EQ(sample(part, 1, x, y), sample(whole, 1, x, y));
    EXPECT_EQ(sample(part, 1, x, 10), 0);
    EXPECT_EQ(sample(part, 1, x, 21), 0);
  }
}

}  // namespace
}  // namespace cupola
