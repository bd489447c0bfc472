// OpenEXR pictures against the sRGB curve in double precision.
// SPDX-License-Identifier: MIT
#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfLineOrder.h>
#include <ImfOutputFile.h>
#include <ImfThreading.h>
#include <ImfTileDescriptionAttribute.h>
#include <ImfTiledOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <half.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "pipeline/frame/error.h"
#include "pipeline/frame/srgb_code.h"
#include "pipeline/frame/still.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using testing::HasSubstr;

int reference(double light) {
  if (!(light > 0.0)) return 0;
  const double x = std::min(light, 1.0);
  const double srgb = x <= 0.0031308 ? x * 12.92 : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
  return static_cast<int>(srgb * 65535.0 + 0.5);
}

struct Kind {
  Imf::PixelType type = Imf::HALF;
  bool tiled = false;
  Imath::Box2i data{{0, 0}, {18, 10}};
  Imath::Box2i display{{0, 0}, {18, 10}};
  std::vector<const char*> channels = {"B", "G", "R", "A"};
  Imf::Compression compression = Imf::ZIP_COMPRESSION;
};

// Of channel `c`, anywhere.
float light_at(int c, int x, int y) {
  return std::exp2(-static_cast<float>((7 * x + 11 * y + 5 * c + 200) % 23) / 2.0F) * 1.5F;
}

void write_kind(const std::filesystem::path& path, const Kind& kind) {
  Imf::Header header(kind.display, kind.data, 1, {0, 0}, 1, Imf::INCREASING_Y, kind.compression);
  const int width = kind.data.max.x - kind.data.min.x + 1;
  const int height = kind.data.max.y - kind.data.min.y + 1;
  std::vector<std::vector<float>> floats;
  std::vector<std::vector<half>> halves;
  std::vector<std::vector<unsigned>> numbers;
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < kind.channels.size(); ++c) {
    header.channels().insert(kind.channels[c], Imf::Channel(kind.type));
    floats.emplace_back();
    for (int y = kind.data.min.y; y <= kind.data.max.y; ++y) {
      for (int x = kind.data.min.x; x <= kind.data.max.x; ++x) {
        floats[c].push_back(light_at(static_cast<int>(c), x, y));
      }
    }
    halves.emplace_back(floats[c].begin(), floats[c].end());
    numbers.emplace_back(floats[c].size(), 1U);
  }
  for (std::size_t c = 0; c < kind.channels.size(); ++c) {
    const std::size_t bytes = kind.type == Imf::HALF ? 2 : 4;
    char* memory = kind.type == Imf::HALF    ? reinterpret_cast<char*>(halves[c].data())
                   : kind.type == Imf::FLOAT ? reinterpret_cast<char*>(floats[c].data())
                                             : reinterpret_cast<char*>(numbers[c].data());
    memory -=
        (kind.data.min.x + std::ptrdiff_t{kind.data.min.y} * width) * static_cast<std::ptrdiff_t>(bytes);
    buffer.insert(kind.channels[c],
                  Imf::Slice(kind.type, memory, bytes, bytes * static_cast<std::size_t>(width)));
  }
  if (kind.tiled) {
    header.setTileDescription(Imf::TileDescription(8, 4));
    Imf::TiledOutputFile file(path.c_str(), header, 0);
    file.setFrameBuffer(buffer);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  } else {
    Imf::OutputFile file(path.c_str(), header, 0);
    file.setFrameBuffer(buffer);
    file.writePixels(height);
  }
}

std::string refusal(const std::filesystem::path& path) {
  try {
    read_still(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

TEST(SrgbCode, IsTheCurveRoundedToNearest) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> exponent(-20.0F, 0.1F);
  for (int i = 0; i < 200'000; ++i) {
    const float light = std::exp2(exponent(random));
    ASSERT_EQ(srgb16_code(light), reference(light)) << light;
  }
  for (int bits = 0; bits < 65536; ++bits) {
    half light;
    light.setBits(static_cast<std::uint16_t>(bits));
    ASSERT_EQ(srgb16_code(light), reference(light)) << light;
  }
  EXPECT_EQ(srgb16_code(std::numeric_limits<float>::infinity()), 65535);
  EXPECT_EQ(srgb16_code(-std::numeric_limits<float>::infinity()), 0);
  EXPECT_EQ(srgb16_code(std::nanf("")), 0);
}

TEST(Exr, OfEveryKindIsReadAsSixteenBitsOfSrgb) {
  TemporaryFolder folder;
  for (const Imf::PixelType type : {Imf::HALF, Imf::FLOAT}) {
    for (const bool tiled : {false, true}) {
      for (const Imf::Compression compression :
           {Imf::NO_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION}) {
        Kind kind;
        kind.type = type;
        kind.tiled = tiled;
        kind.compression = compression;
        write_kind(folder / "a.exr", kind);
        const StillInfo info = probe_still(folder / "a.exr");
        EXPECT_EQ(info.size, (Size{19, 11}));
        EXPECT_EQ(info.format, PixelFormat::kRgbPlanar16);
        const ImageBuffer image = read_still(folder / "a.exr");
        for (int y = 0; y < 11; ++y) {
          for (int x = 0; x < 19; ++x) {
            for (int c = 0; c < 3; ++c) {
              const float light = light_at(2 - c, x, y);
              const double stored = type == Imf::HALF ? static_cast<double>(half(light)) : light;
              ASSERT_EQ(sample(image, c, x, y), reference(stored)) << c << " " << x << " " << y;
            }
          }
        }
      }
    }
  }
  EXPECT_EQ(Imf::globalThreadCount(), 0);
}

TEST(Exr, ShowsItsDisplayWindowAndBlackWhereItHasNoData) {
  TemporaryFolder folder;
  for (const bool tiled : {false, true}) {
    Kind kind;
    kind.type = Imf::FLOAT;
    kind.tiled = tiled;
    kind.data = {{-5, 3}, {9, 30}};
    kind.display = {{-2, -1}, {13, 17}};
    write_kind(folder / "a.exr", kind);
    const ImageBuffer image = read_still(folder / "a.exr");
    ASSERT_EQ(image.size(), (Size{16, 19}));
    for (int y = 0; y < 19; ++y) {
      for (int x = 0; x < 16; ++x) {
        const bool there = x - 2 <= 9 && y - 1 >= 3;
        ASSERT_EQ(sample(image, 0, x, y), there ? reference(light_at(2, x - 2, y - 1)) : 0) << x << " " << y;
      }
    }
    // A part of the rows is the same.
    ImageBuffer part(PixelFormat::kRgbPlanar16, {16, 19});
    FileBytes memory;
    EXPECT_EQ(read_still_into(folder / "a.exr", part.pixels(), {7, 12}, memory), 14);
    for (int y = 7; y < 12; ++y) {
      for (int x = 0; x < 16; ++x) ASSERT_EQ(sample(part, 1, x, y), sample(image, 1, x, y));
    }
  }
}

TEST(Exr, AsWrittenIsTheLightOfEveryCodeInHalfFloats) {
  TemporaryFolder folder;
  ImageBuffer codes(PixelFormat::kRgb16, {256, 256});
  for (int i = 0; i < 65536; ++i) {
    auto* row = codes.pixels().samples<std::uint16_t>(0, i / 256);
    for (int c = 0; c < 3; ++c) row[3 * (i % 256) + c] = static_cast<std::uint16_t>(c == 1 ? 65535 - i : i);
  }
  write_exr(folder / "a.exr", as_const(codes.pixels()));

  Imf::InputFile file((folder / "a.exr").c_str());
  EXPECT_TRUE(file.header().channels().findChannel("R")->type == Imf::HALF);
  std::vector<half> green(65536);
  Imf::FrameBuffer buffer;
  buffer.insert("G", Imf::Slice(Imf::HALF, reinterpret_cast<char*>(green.data()), 2, 512));
  file.setFrameBuffer(buffer);
  file.readPixels(0, 255);
  const ImageBuffer back = read_still(folder / "a.exr");
  int most = 0;
  for (int i = 0; i < 65536; ++i) {
    const double srgb = (65535 - i) / 65535.0;
    const double light = srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
    ASSERT_EQ(green[static_cast<std::size_t>(i)], half(static_cast<float>(light))) << i;
    const int error = std::abs(sample(back, 0, i % 256, i / 256) - i);
    most = std::max(most, error);
    if (i % 257 == 0) {
      ASSERT_EQ((sample(back, 0, i % 256, i / 256) + 128) / 257, i / 257) << "8 bits";
    }
  }
  EXPECT_LE(most, 10);
}

TEST(Exr, ThatCannotBeWrittenLeavesNothing) {
  TemporaryFolder folder;
  const ImageBuffer picture(PixelFormat::kRgb8, {5, 3});
  write_text(folder / "file", "");
  EXPECT_THROW(write_exr(folder / "file/a.exr", picture.pixels()), Failure);
  write_exr(folder / "b.exr", picture.pixels());
  EXPECT_EQ(read_still(folder / "b.exr").size(), (Size{5, 3}));
  EXPECT_EQ(folder.names(), (std::vector<std::string>{"b.exr", "file"}));
}

TEST(Exr, OfLuminanceAloneIsGrey) {
  TemporaryFolder folder;
  Kind kind;
  kind.channels = {"Y"};
  write_kind(folder / "a.exr", kind);
  const ImageBuffer image = read_still(folder / "a.exr");
  for (int c = 0; c < 3; ++c) EXPECT_EQ(sample(image, c, 3, 4), reference(half(light_at(0, 3, 4))));
}

TEST(Exr, ThatCannotBeReadIsRefusedByName) {
  TemporaryFolder folder;
  const std::filesystem::path path = folder / "a.exr";
  Kind kind;
  kind.channels = {"R", "G"};
  write_kind(path, kind);
  EXPECT_EQ(refusal(path), path.string() + ": the EXR has channels G R; expected R, G and B, or Y alone");
  kind = {};
  kind.type = Imf::UINT;
  write_kind(path, kind);
  EXPECT_THAT(refusal(path), HasSubstr("whole numbers; expected half or float"));
  write_kind(path, {});
  const std::string whole = read_text(path);
  for (const std::size_t bytes :
       {std::size_t{4}, std::size_t{9}, std::size_t{100}, whole.size() / 2, whole.size() - 9}) {
    write_text(path, whole.substr(0, bytes));
    EXPECT_THAT(refusal(path), HasSubstr("a.exr: the EXR ")) << bytes;
  }
  for (const char* window : {"dataWindow", "displayWindow"}) {
    std::string giant = whole;
    const std::size_t value = giant.find(window) + std::strlen(window) + 1 + 6 + 4;  // name, "box2i", size
    giant.replace(value + 8, 4, std::string("\xff\xff\xff\x7f", 4));
    write_text(path, giant);
    EXPECT_THAT(refusal(path), HasSubstr("expected sides of 1 to 32768")) << window;
  }
}

TEST(Exr, DamagedAnywhereIsReadOrRefused) {
  TemporaryFolder folder;
  for (const bool tiled : {false, true}) {
    Kind kind;
    kind.tiled = tiled;
    write_kind(folder / "a.exr", kind);
    const std::string whole = read_text(folder / "a.exr");
    std::mt19937 random(5);
    for (int i = 0; i < 3000; ++i) {
      std::string bytes = whole;
      for (int flips = 0; flips < 1 + i % 3; ++flips)
        bytes[4 + random() % (bytes.size() - 4)] ^= static_cast<char>(1U << random() % 8);
      const auto file = std::as_bytes(std::span(bytes));
      try {
        const StillInfo info = probe_still(file, "damaged");
        if (std::int64_t{info.size.width} * info.size.height > 300'000) continue;
        ImageBuffer image(info.format, info.size);
        decode_still(file, "damaged", image.pixels());
      } catch (const InputError&) {
      }
    }
  }
}

}  // namespace
}  // namespace cupola
