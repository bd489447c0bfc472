// Y4M videos in and out.
// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>

#include "pipeline/frame/error.h"
#include "pipeline/frame/y4m_reader.h"
#include "pipeline/frame/y4m_writer.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

ImageBuffer read_frame(Y4mReader& reader, std::int64_t frame) {
  ImageBuffer image(reader.format(), reader.size());
  reader.read(frame, image.pixels());
  return image;
}

std::string refusal(const TemporaryFolder& folder, const std::string& file) {
  write_text(folder / "a.y4m", file);
  try {
    Y4mReader reader(folder / "a.y4m");
    for (std::int64_t i = 0; i < reader.frames(); ++i) read_frame(reader, i);
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

// Planes of deterministic noise, samples of `bits`.
struct Planes {
  int width, height, chroma_width, chroma_height, bits;
  std::vector<int> y, u, v;

  Planes(int w, int h, int shift_x, int shift_y, int depth, bool colour = true)
      : width(w),
        height(h),
        chroma_width((w + shift_x) >> shift_x),
        chroma_height((h + shift_y) >> shift_y),
        bits(depth) {
    std::uint32_t state = 7;
    const auto fill = [&](std::vector<int>& plane, int count) {
      for (int i = 0; i < count; ++i) {
        state = state * 1664525U + 1013904223U;
        plane.push_back(static_cast<int>(state >> (32 - depth)));
      }
    };
    fill(y, w * h);
    if (colour) fill(u, chroma_width * chroma_height), fill(v, chroma_width * chroma_height);
  }
  std::string frame() const {
    std::string text = "FRAME\n";
    for (const std::vector<int>* plane : {&y, &u, &v}) {
      for (const int value : *plane) {
        text += static_cast<char>(value);
        if (bits > 8) text += static_cast<char>(value >> 8);
      }
    }
    return text;
  }
};

// A chroma sample at luma pixel (x, y): linear between centres, in real numbers.
double chroma_at(const Planes& planes, const std::vector<int>& plane, int x, int y, double shift_x,
                 double shift_y, double offset_x, double offset_y) {
  const double u = std::clamp((x - offset_x) / shift_x, 0.0, planes.chroma_width - 1.0);
  const double v = std::clamp((y - offset_y) / shift_y, 0.0, planes.chroma_height - 1.0);
  const int i = std::min(static_cast<int>(u), planes.chroma_width - 1),
            j = std::min(static_cast<int>(v), planes.chroma_height - 1);
  const int i1 = std::min(i + 1, planes.chroma_width - 1), j1 = std::min(j + 1, planes.chroma_height - 1);
  const auto at = [&](int a, int b) { return plane[static_cast<std::size_t>(b * planes.chroma_width + a)]; };
  return (at(i, j) * (i + 1 - u) + at(i1, j) * (u - i)) * (j + 1 - v) +
         (at(i, j1) * (i + 1 - u) + at(i1, j1) * (u - i)) * (v - j);
}

struct Kind {
  const char* tag;
  int shift_x, shift_y, bits;
  double offset_x, offset_y;  // of the first chroma sample, luma pixels
  bool colour = true;
};

TEST(Y4mReader, IsTheNearestIntegerToTheRealConversionInEveryKind) {
  const TemporaryFolder folder;
  for (const Kind& kind :
       {Kind{"C420jpeg", 1, 1, 8, 0.5, 0.5}, Kind{"C420", 1, 1, 8, 0.5, 0.5},
        Kind{"C420mpeg2", 1, 1, 8, 0, 0.5}, Kind{"C420paldv", 1, 1, 8, 0, 0}, Kind{"C422", 1, 0, 8, 0, 0},
        Kind{"C444", 0, 0, 8, 0, 0}, Kind{"Cmono", 0, 0, 8, 0, 0, false}, Kind{"C420p10", 1, 1, 10, 0, 0.5},
        Kind{"C422p12", 1, 0, 12, 0, 0}, Kind{"C444p16", 0, 0, 16, 0, 0}, Kind{"C444p12", 0, 0, 12, 0, 0},
        Kind{"Cmono10", 0, 0, 10, 0, 0, false}}) {
    for (const bool full : {false, true}) {
      const Planes planes(13, 11, kind.shift_x, kind.shift_y, kind.bits, kind.colour);
      const std::string range = full ? " XCOLORRANGE=FULL" : "";
      write_text(folder / "a.y4m",
                 std::string("YUV4MPEG2 W13 H11 F25:1 Ip A1:1 ") + kind.tag + range + "\n" + planes.frame());
      Y4mReader reader(folder / "a.y4m");
      ASSERT_EQ(reader.frames(), 1);
      const ImageBuffer image = read_frame(reader, 0);
      const double most = kind.bits > 8 ? 65'535 : 255, scale = std::ldexp(1.0, kind.bits - 8);
      const double largest = 256 * scale - 1;
      for (int y = 0; y < 11; ++y) {
        for (int x = 0; x < 13; ++x) {
          const double luma_at = planes.y[static_cast<std::size_t>(y * 13 + x)];
          const double luma = full ? luma_at / largest : (luma_at - 16 * scale) / (219 * scale);
          double chroma[2] = {};
          for (int c = 0; kind.colour && c < 2; ++c) {
            const double raw = chroma_at(planes, c == 0 ? planes.u : planes.v, x, y, 1 + kind.shift_x,
                                         1 + kind.shift_y, kind.offset_x, kind.offset_y);
            chroma[c] = (raw - 128 * scale) / (full ? largest : 224 * scale);
          }
          const double expected[3] = {
              luma + 1.5748 * chroma[1],
              luma - 0.0722 / 0.7152 * 1.8556 * chroma[0] - 0.2126 / 0.7152 * 1.5748 * chroma[1],
              luma + 1.8556 * chroma[0]};
          for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(sample(image, c, x, y), std::clamp(expected[c], 0.0, 1.0) * most, 0.51)
                << kind.tag << range;
        }
      }
    }
  }
}

TEST(Y4mReader, KnowsBlackAndWhiteExactly) {
  const TemporaryFolder folder;
  write_text(folder / "a.y4m", std::string("YUV4MPEG2 W2 H1 F1:1 C444\nFRAME\n\x10\xeb\x80\x80\x80\x80"));
  Y4mReader reader(folder / "a.y4m");
  const ImageBuffer image = read_frame(reader, 0);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(sample(image, c, 0, 0), 0);
    EXPECT_EQ(sample(image, c, 1, 0), 255);
  }
}

TEST(Y4mReader, ReadsAnyFrameInAnyOrder) {
  const TemporaryFolder folder;
  Y4mWriter writer(folder / "a.y4m", {16, 8}, {30'000, 1'001});
  std::vector<ImageBuffer> images;
  for (std::uint32_t i = 0; i < 5; ++i) {
    images.push_back(smooth_picture(PixelFormat::kRgbPlanar8, {16, 8}));
    images.back().pixels().samples<std::uint8_t>(0, 0)[0] = static_cast<std::uint8_t>(40 * i);
    writer.write(images.back().pixels());
  }
  writer.finish();
  Y4mReader reader(folder / "a.y4m");
  EXPECT_EQ(reader.frames(), 5);
  EXPECT_EQ(reader.header().rate.numerator, 30'000);
  EXPECT_EQ(reader.header().rate.denominator, 1'001);
  for (const int i : {3, 0, 4, 4, 1}) {
    EXPECT_LE(
        largest_difference(read_frame(reader, i).pixels(), images[static_cast<std::size_t>(i)].pixels()), 2);
  }
  ImageBuffer image(PixelFormat::kRgbPlanar8, {16, 8});
  EXPECT_THROW(reader.read(5, image.pixels()), InputError);
  EXPECT_THROW(reader.read(-1, image.pixels()), InputError);
}

TEST(Y4mReader, GivesTheSameRowsWhenOnlySomeAreAskedFor) {
  const TemporaryFolder folder;
  for (const char* tag : {"C420jpeg", "C420paldv", "C422", "C444"}) {
    const Planes planes(14, 21, tag[3] == '4' ? 0 : 1, tag[2] == '2' && tag[3] == '0' ? 1 : 0, 8);
    write_text(folder / "a.y4m", std::string("YUV4MPEG2 W14 H21 F25:1 ") + tag + "\n" + planes.frame());
    Y4mReader reader(folder / "a.y4m");
    const ImageBuffer whole = read_frame(reader, 0);
    for (int first = 0; first < 21; ++first) {
      for (int last = first + 1; last <= 21; ++last) {
        ImageBuffer part(PixelFormat::kRgbPlanar8, {14, 21});
        reader.read(0, part.pixels(), {first, last});
        const Size rows{14, last - first};
        ASSERT_EQ(largest_difference(part_of(std::as_const(part).pixels(), 0, first, rows),
                                     part_of(whole.pixels(), 0, first, rows)),
                  0);
      }
    }
  }
}

TEST(Y4mReader, RefusesWhatItDoesNotUnderstand) {
  const TemporaryFolder folder;
  const std::string frame = Planes(4, 4, 1, 1, 8).frame();
  const std::string start = "YUV4MPEG2 W4 H4 F25:1 ";
  EXPECT_EQ(refusal(folder, start + "Ip\n" + frame), "taken");
  EXPECT_EQ(refusal(folder, start + "Ip XYSCSS=420JPEG  XSOMETHING A0:0\n" + frame), "taken");
  EXPECT_THAT(refusal(folder, "RIFF"), HasSubstr("YUV4MPEG2"));
  EXPECT_THAT(refusal(folder, start + "It\n" + frame), HasSubstr("interlaced"));
  EXPECT_THAT(refusal(folder, start + "C444alpha\n" + frame), HasSubstr("C444alpha"));
  EXPECT_THAT(refusal(folder, start + "C410\n" + frame), HasSubstr("C410"));
  EXPECT_THAT(refusal(folder, start + "C420p99\n" + frame), HasSubstr("C420p99"));
  EXPECT_THAT(refusal(folder, "YUV4MPEG2 W0 H4\n" + frame), HasSubstr("0 x 4"));
  EXPECT_THAT(refusal(folder, "YUV4MPEG2 H4\n" + frame), HasSubstr("0 x 4"));
  EXPECT_THAT(refusal(folder, "YUV4MPEG2 W65536 H4\n" + frame), HasSubstr("65536 x 4"));
  EXPECT_THAT(refusal(folder, "YUV4MPEG2 W99999999999 H4\n" + frame), HasSubstr("not understood"));
  EXPECT_THAT(refusal(folder, "YUV4MPEG2 W-4 H4\n" + frame), HasSubstr("not understood"));
  EXPECT_THAT(refusal(folder, "YUV4MPEG2 W4 H4 " + std::string(2000, 'X')), HasSubstr("does not end"));
  EXPECT_THAT(refusal(folder, start + "\nFRAME Ixyz\n" + frame.substr(6)), HasSubstr("parameters"));
  EXPECT_THAT(refusal(folder, start + "\n" + frame + "FRAMX\n" + frame.substr(6)), HasSubstr("frame 1"));
  EXPECT_THAT(refusal(folder, ""), HasSubstr("empty"));
}

TEST(Y4mReader, RefusesAFileCutShortAnywhereButBetweenFrames) {
  const TemporaryFolder folder;
  const std::string start = "YUV4MPEG2 W4 H4 F25:1 Ip\n", frame = Planes(4, 4, 1, 1, 8).frame();
  const std::string whole = start + frame + frame;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    if (length == start.size() + frame.size()) continue;
    ASSERT_NE(refusal(folder, whole.substr(0, length)), "taken") << length;
  }
}

TEST(Y4mWriter, KeepsRgbWithinTwoSteps) {
  const TemporaryFolder folder;
  ImageBuffer image(PixelFormat::kRgb8, {64, 64});  // every 16th value of every channel, and the ends
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      auto* pixel = image.pixels().samples<std::uint8_t>(0, y) + 3 * x;
      pixel[0] = static_cast<std::uint8_t>(17 * (x % 16));
      pixel[1] = static_cast<std::uint8_t>(17 * (y % 16));
      pixel[2] = static_cast<std::uint8_t>(17 * (x / 16 + 4 * (y / 16)));
    }
  }
  Y4mWriter writer(folder / "a.y4m", {64, 64}, {30, 1});
  writer.write(image.pixels());
  writer.finish();
  Y4mReader reader(folder / "a.y4m");
  EXPECT_LE(largest_difference(read_frame(reader, 0).pixels(), image.pixels()), 2);
}

TEST(Y4mWriter, KeepsGreysNeutralAndRoundsSixteenBitsOnce) {
  const TemporaryFolder folder;
  ImageBuffer image(PixelFormat::kRgbPlanar16, {256, 256});
  for (int v = 0; v < 65'536; ++v)
    for (int p = 0; p < 3; ++p)
      image.pixels().samples<std::uint16_t>(p, v / 256)[v % 256] = static_cast<std::uint16_t>(v);
  Y4mWriter writer(folder / "a.y4m", {256, 256}, {30, 1});
  writer.write(image.pixels());
  writer.finish();
  const std::string file = read_text(folder / "a.y4m");
  const std::string planes = file.substr(file.size() - 3 * 65'536);
  for (std::size_t v = 0; v < 65'536; ++v) {
    ASSERT_EQ(static_cast<unsigned char>(planes[v]), std::lround(16 + static_cast<double>(v) * 219 / 65'535))
        << v;
    ASSERT_EQ(planes[65'536 + v], '\x80');
    ASSERT_EQ(planes[2 * 65'536 + v], '\x80');
  }
}

TEST(Y4mWriter, HasTenBitsWhereItIsAskedTo) {
  const TemporaryFolder folder;
  ImageBuffer image(PixelFormat::kRgbPlanar16, {256, 256});
  for (int v = 0; v < 65'536; ++v)
    for (int p = 0; p < 3; ++p)
      image.pixels().samples<std::uint16_t>(p, v / 256)[v % 256] = static_cast<std::uint16_t>(v);
  Y4mWriter writer(folder / "a.y4m", {256, 256}, {30, 1}, 10);
  writer.write(image.pixels());
  writer.finish();
  const std::string file = read_text(folder / "a.y4m");
  ASSERT_NE(file.find(" C444p10 "), std::string::npos);
  const std::string planes = file.substr(file.size() - 6 * 65'536);
  const auto word = [&](std::size_t i) {
    return static_cast<unsigned char>(planes[2 * i]) + 256 * static_cast<unsigned char>(planes[2 * i + 1]);
  };
  for (std::size_t v = 0; v < 65'536; ++v) {
    ASSERT_EQ(word(v), std::lround(64 + static_cast<double>(v) * 876 / 65'535)) << v;
    ASSERT_EQ(word(65'536 + v), 512);
    ASSERT_EQ(word(2 * 65'536 + v), 512);
  }
}

TEST(Y4mWriter, IsUnderstoodByFfmpegAsTheSameColours) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not installed";
  const TemporaryFolder folder;
  const ImageBuffer image = smooth_picture(PixelFormat::kRgb8, {64, 48});
  for (const int bits : {8, 10}) {
    Y4mWriter writer(folder / "a.y4m", {64, 48}, {30, 1}, bits);
    writer.write(image.pixels());
    writer.finish();
    const std::string command =
        "ffmpeg -v error -y -i " + (folder / "a.y4m").string() +
        " -vf scale=in_color_matrix=bt709:flags=accurate_rnd+full_chroma_int -f rawvideo -pix_fmt rgb24 " +
        (folder / "a.rgb").string();
    ASSERT_EQ(std::system(command.c_str()), 0);
    const std::string raw = read_text(folder / "a.rgb");
    ASSERT_EQ(raw.size(), std::size_t{64 * 48 * 3});
    int largest = 0;
    for (int i = 0; i < 64 * 48 * 3; ++i) {
      const int theirs = static_cast<unsigned char>(raw[static_cast<std::size_t>(i)]);
      largest = std::max(largest, std::abs(theirs - sample(image, i % 3, i / 3 % 64, i / 192)));
    }
    EXPECT_LE(largest, bits == 8 ? 3 : 1);
  }
}

TEST(Y4mReader, ReadsWhatFfmpegWrites) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not installed";
  const TemporaryFolder folder;
  for (const char* format : {"yuv420p", "yuvj420p", "yuv422p", "yuv444p", "gray", "yuv420p10le",
                             "yuv422p12le", "yuv444p16le", "gray10le", "gray16le"}) {
    const std::string path = (folder / "a.y4m").string();
    const std::string command =
        std::string("ffmpeg -v error -y -f lavfi -i testsrc2=s=66x34:r=25:d=0.12 -strict -1 -pix_fmt ") +
        format + " " + path;
    ASSERT_EQ(std::system(command.c_str()), 0) << format;
    Y4mReader reader(path);
    EXPECT_EQ(reader.frames(), 3) << format;
    EXPECT_EQ(reader.size(), (Size{66, 34}));
    read_frame(reader, 2);
  }
}

TEST(Y4mWriter, WritesToStandardOutputAndFailsWhenNobodyReads) {
  const ImageBuffer image = smooth_picture(PixelFormat::kRgb8, {256, 256});
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  std::fflush(stdout);
  const int kept = ::dup(STDOUT_FILENO);
  ASSERT_EQ(::dup2(ends[1], STDOUT_FILENO), STDOUT_FILENO);
  ::close(ends[1]);
  ::close(ends[0]);
  auto* handler = std::signal(SIGPIPE, SIG_IGN);
  bool failed = false;
  try {
    Y4mWriter writer("-", {256, 256}, {30, 1});
    for (int i = 0; i < 10; ++i) writer.write(image.pixels());
    writer.finish();
  } catch (const Failure& failure) {
    failed = std::string_view(failure.what()).starts_with("standard output: cannot be written");
  }
  std::signal(SIGPIPE, handler);
  ::dup2(kept, STDOUT_FILENO);
  ::close(kept);
  EXPECT_TRUE(failed);
}

TEST(Y4mWriter, LeavesNothingWhenItIsGivenUp) {
  const TemporaryFolder folder;
  {
    Y4mWriter writer(folder / "a.y4m", {4, 4}, {30, 1});
    writer.write(ImageBuffer(PixelFormat::kRgb8, {4, 4}).pixels());
  }
  EXPECT_THAT(folder.names(), IsEmpty());
}

}  // namespace
}  // namespace cupola
