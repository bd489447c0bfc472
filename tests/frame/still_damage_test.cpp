// Stills that must be refused: other kinds, damaged, cut short, hostile.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <tiffio.h>

#include "pipeline/frame/error.h"
#include "pipeline/frame/still.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using testing::HasSubstr;

ImageBuffer decode(const std::string& file) {
  const auto bytes = std::as_bytes(std::span(file));
  const StillInfo info = probe_still(bytes, "a-name");
  ImageBuffer image(info.format, info.size);
  decode_still(bytes, "a-name", image.pixels());
  return image;
}

std::string refusal(const std::string& file) {
  try {
    decode(file);
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("a-name: "));
    return error.what();
  }
  return "taken";
}

std::string file_refusal(const std::filesystem::path& path) {
  try {
    read_still(path);
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(path.string()));
    return error.what();
  }
  return "taken";
}

// A small uncompressed TIFF whose directory comes before the data, so that it can be cut within them.
struct TinyTiff {
  std::uint32_t width = 4, height = 4;
  std::uint16_t bits = 8, samples = 3, photometric = PHOTOMETRIC_RGB, planes = PLANARCONFIG_CONTIG,
                form = SAMPLEFORMAT_UINT;
  bool second_page = false;

  std::string file() const {
    const auto little = [](std::uint32_t value, int bytes) {
      std::string text;
      for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i));
      return text;
    };
    std::string entries;
    int count = 0;
    const auto add = [&](std::uint32_t tag, std::uint32_t value) {
      entries += little(tag, 2) + little(4, 2) + little(1, 4) + little(value, 4);
      ++count;
    };
    const std::uint32_t length = width * height * samples * bits / 8;
    constexpr std::uint32_t kData = 8 + 2 + 12 * 12 + 4;
    add(TIFFTAG_IMAGEWIDTH, width), add(TIFFTAG_IMAGELENGTH, height), add(TIFFTAG_BITSPERSAMPLE, bits);
    add(TIFFTAG_COMPRESSION, COMPRESSION_NONE), add(TIFFTAG_PHOTOMETRIC, photometric);
    add(TIFFTAG_STRIPOFFSETS, kData), add(TIFFTAG_ORIENTATION, 1), add(TIFFTAG_SAMPLESPERPIXEL, samples);
    add(TIFFTAG_ROWSPERSTRIP, height), add(TIFFTAG_STRIPBYTECOUNTS, length),
        add(TIFFTAG_PLANARCONFIG, planes);
    add(TIFFTAG_SAMPLEFORMAT, form);
    const std::uint32_t taken = std::min(length, 100'000U);
    std::string file =
        "II" + little(42, 2) + little(8, 4) + little(static_cast<std::uint32_t>(count), 2) + entries;
    file += little(second_page ? kData + taken : 0, 4);
    file += std::string(taken, 'x');
    if (second_page) file += little(static_cast<std::uint32_t>(count), 2) + entries + little(0, 4);
    return file;
  }
};

TEST(StillRefusal, NamesAFileThatIsMissingAFolderEmptyOrNoPicture) {
  const TemporaryFolder folder;
  write_text(folder / "empty", "");
  write_text(folder / "text", "What light through yonder window breaks?");
  write_text(folder / "short", "\x89P");
  ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
  EXPECT_THAT(file_refusal(folder / "missing"), HasSubstr("No such file"));
  EXPECT_THAT(file_refusal(folder.path()), HasSubstr("is a folder"));
  EXPECT_THAT(file_refusal(folder / "empty"), HasSubstr("is empty"));
  EXPECT_THAT(file_refusal(folder / "text"), HasSubstr("expected a PNG, JPEG, TIFF or EXR picture"));
  EXPECT_THAT(file_refusal(folder / "short"), HasSubstr("not a picture"));
  EXPECT_THAT(file_refusal(folder / "fifo"),
              HasSubstr("not a regular file"));  // and does not wait for a writer
  EXPECT_THROW(probe_still(folder / "missing"), InputError);
}

TEST(StillRefusal, NamesAnAnimatedPng) {
  const ImageBuffer image = noise_picture(PixelFormat::kRgbPlanar8, {4, 4});
  const std::string animated =
      png_file(image.pixels(), false, png_chunk("acTL", std::string("\0\0\0\2\0\0\0\0", 8)));
  EXPECT_THAT(refusal(animated), HasSubstr("animated PNG"));
}

TEST(StillRefusal, NamesSidesOfZeroAndTooLargeOnesBeforeAnythingIsAllocated) {
  const auto png = [](std::uint32_t width, std::uint32_t height) {
    return kPngSignature + png_header(width, height, 8, 2) + png_data("") + kPngEnd;
  };
  EXPECT_THAT(refusal(png(0, 0)), HasSubstr("0 x 0"));
  EXPECT_THAT(refusal(png(10, 0)), HasSubstr("10 x 0"));
  EXPECT_THAT(refusal(png(65'536, 4)), HasSubstr("65536 x 4; expected sides of 1 to 32768"));
  EXPECT_THAT(refusal(png(0xffffffff, 0xffffffff)), HasSubstr("expected sides"));
  EXPECT_THAT(refusal(png(32'768, 32'768)), HasSubstr("at most 536870912 pixels"));

  const ImageBuffer image = noise_picture(PixelFormat::kRgbPlanar8, {8, 8});
  std::string jpeg = jpeg_file(image.pixels());
  const std::size_t frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  jpeg.replace(frame + 5, 4, "\xff\xdc\xff\xdc");  // 65,500, the largest a JPEG may have
  EXPECT_THAT(refusal(jpeg), HasSubstr("65500 x 65500"));
  jpeg.replace(frame + 5, 4, std::string(4, '\0'));
  EXPECT_NE(refusal(jpeg), "taken");

  EXPECT_THAT(refusal(TinyTiff{.width = 65'536, .height = 1}.file()), HasSubstr("65536 x 1"));
  EXPECT_THAT(refusal(TinyTiff{.width = 0}.file()), HasSubstr("a-name"));
}

TEST(StillRefusal, NamesAPngThatPromisesMorePixelsThanItsBytesCanHold) {
  EXPECT_THAT(refusal(kPngSignature + png_header(16'384, 16'384, 16, 6) + png_data("") + kPngEnd),
              HasSubstr("cut short"));
}

TEST(StillRefusal, NamesTheColoursOfAPrintersJpeg) {
  const ImageBuffer image = noise_picture(PixelFormat::kRgbPlanar8, {16, 16});
  EXPECT_THAT(refusal(jpeg_file(image.pixels(), {.components = 4})), HasSubstr("is a CMYK JPEG"));
  EXPECT_THAT(refusal(jpeg_file(image.pixels(), {.components = 4, .ycck = true})),
              HasSubstr("is a YCCK JPEG"));
}

TEST(StillRefusal, NamesTheKindsOfTiffThatAreNotTaken) {
  EXPECT_EQ(refusal(TinyTiff{}.file()), "taken");
  EXPECT_THAT(refusal(TinyTiff{.second_page = true}.file()), HasSubstr("several pages"));
  EXPECT_THAT(refusal(TinyTiff{.samples = 4, .photometric = PHOTOMETRIC_SEPARATED}.file()),
              HasSubstr("is CMYK"));
  EXPECT_THAT(refusal(TinyTiff{.bits = 32, .form = SAMPLEFORMAT_IEEEFP}.file()), HasSubstr("floating-point"));
  EXPECT_THAT(refusal(TinyTiff{.form = SAMPLEFORMAT_INT}.file()), HasSubstr("signed"));
  EXPECT_THAT(refusal(TinyTiff{.bits = 32}.file()), HasSubstr("3 samples of 32 bits"));
  EXPECT_THAT(refusal(TinyTiff{.planes = PLANARCONFIG_SEPARATE}.file()), HasSubstr("planes apart"));
  EXPECT_THAT(refusal(TinyTiff{.photometric = PHOTOMETRIC_CIELAB}.file()), HasSubstr("colours of kind 8"));
  EXPECT_THAT(refusal(TinyTiff{.samples = 1}.file()), HasSubstr("1 samples"));
}

TEST(StillRefusal, NamesATiledTiff) {
  const TemporaryFolder folder;
  TIFF* tiff = TIFFOpen((folder / "a.tif").c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 16);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 16);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16);
  TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
  std::uint8_t tile[256] = {};
  TIFFWriteTile(tiff, tile, 0, 0, 0, 0);
  TIFFClose(tiff);
  EXPECT_THAT(file_refusal(folder / "a.tif"), HasSubstr("is tiled"));
}

TEST(StillRefusal, TakesNoJpegOfThousandsOfScans) {
  const ImageBuffer image = smooth_picture(PixelFormat::kRgbPlanar8, {16, 16});
  std::string file = jpeg_file(image.pixels(), {.progressive = true});
  const std::size_t scan = file.rfind("\xff\xda");
  const std::string last = file.substr(scan, file.size() - 2 - scan);
  file.resize(file.size() - 2);
  for (int i = 0; i < 2000; ++i) file += last;
  file += "\xff\xd9";
  EXPECT_NE(refusal(file), "taken");
}

struct Sample {
  const char* name;
  std::string file;
};

std::vector<Sample> samples() {
  const ImageBuffer image = noise_picture(PixelFormat::kRgbPlanar8, {23, 17});
  const ImageBuffer deep = noise_picture(PixelFormat::kRgbPlanar16, {23, 17});
  const TemporaryFolder folder;
  write_png(folder / "deep.png", deep.pixels());
  TIFF* tiff = TIFFOpen((folder / "packed.tif").c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 23);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 17);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_LZW);
  for (int y = 0; y < 17; ++y) {
    std::uint8_t row[23];
    for (int x = 0; x < 23; ++x) row[x] = static_cast<std::uint8_t>(sample(image, 0, x, y));
    TIFFWriteScanline(tiff, row, static_cast<std::uint32_t>(y), 0);
  }
  TIFFClose(tiff);
  return {{"png", png_file(image.pixels())},
          {"interlaced png", png_file(image.pixels(), true)},
          {"written png", read_text(folder / "deep.png")},
          {"jpeg", jpeg_file(image.pixels())},
          {"progressive jpeg", jpeg_file(image.pixels(), {.progressive = true})},
          {"grey jpeg", jpeg_file(image.pixels(), {.components = 1})},
          {"tiff", TinyTiff{.width = 23, .height = 17}.file()},
          {"packed tiff", read_text(folder / "packed.tif")}};
}

TEST(StillDamage, EveryFileCutShortAnywhereIsRefused) {
  for (const Sample& whole : samples()) {
    ASSERT_EQ(refusal(whole.file), "taken") << whole.name;
    for (std::size_t length = 0; length < whole.file.size(); ++length) {
      ASSERT_NE(refusal(whole.file.substr(0, length)), "taken")
          << whole.name << " of " << whole.file.size() << " cut to " << length;
    }
  }
}

TEST(StillDamage, EveryByteOfAPngThatMattersIsProtectedByItsChecksums) {
  const ImageBuffer image = noise_picture(PixelFormat::kRgbPlanar8, {23, 17});
  const std::string whole = png_file(image.pixels());
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string file = whole;
    file[at] = static_cast<char>(file[at] ^ 0x20);
    ASSERT_NE(refusal(file), "taken") << at << " of " << whole.size();
  }
}

TEST(StillDamage, NoFlippedBitCrashes) {
  for (const Sample& whole : samples()) {
    for (std::size_t bit = 0; bit < 8 * whole.file.size(); bit += 3) {
      std::string file = whole.file;
      file[bit / 8] = static_cast<char>(file[bit / 8] ^ (1 << bit % 8));
      try {
        const StillInfo info = probe_still(std::as_bytes(std::span(file)), "a-name");
        if (std::int64_t{info.size.width} * info.size.height < 1'000'000) decode(file);
      } catch (const InputError&) {
      }
    }
  }
}

}  // namespace
}  // namespace cupola
