// PNG, JPEG and TIFF in all the kinds that are taken.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/still.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include "pipeline/frame/error.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

ImageBuffer decode(const std::string& file) {
  const auto bytes = std::as_bytes(std::span(file));
  const StillInfo info = probe_still(bytes, "test");
  ImageBuffer image(info.format, info.size);
  decode_still(bytes, "test", image.pixels());
  return image;
}

TEST(Png, ComesBackToTheBitInEveryFormatOfOurs) {
  const TemporaryFolder folder;
  for (const PixelFormat format : {PixelFormat::kRgbPlanar8, PixelFormat::kRgbPlanar16, PixelFormat::kRgb8,
                                   PixelFormat::kRgb16, PixelFormat::kXrgb8888}) {
    for (const Size size : {Size{1, 1}, Size{37, 23}, Size{300, 2}}) {
      const ImageBuffer image = noise_picture(format, size);
      write_png(folder / "a.png", image.pixels());
      const ImageBuffer back = read_still(folder / "a.png");
      EXPECT_EQ(back.format(),
                sample_bytes(format) == 2 ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8);
      EXPECT_EQ(largest_difference(image.pixels(), back.pixels()), 0);
    }
  }
}

TEST(Png, IsKnownByItsContentWhateverItsName) {
  const TemporaryFolder folder;
  const ImageBuffer image = noise_picture(PixelFormat::kRgb8, {5, 4});
  write_png(folder / "a.jpg", image.pixels());
  EXPECT_EQ(probe_still(folder / "a.jpg").size, (Size{5, 4}));
}

TEST(Png, TakesGreyOfEveryDepth) {
  // Four pixels: 0, 1, 2, 3 of 2 bits; 8 and 16 bits; 1 bit.
  const auto file = [](int depth, std::string_view row) {
    return kPngSignature + png_header(4, 1, depth, 0) + png_data(std::string(1, '\0') + std::string(row)) +
           kPngEnd;
  };
  const ImageBuffer one = decode(file(1, "\x50"));
  const ImageBuffer two = decode(file(2, "\x1b"));
  const ImageBuffer eight = decode(file(8, std::string_view("\x00\x11\x80\xff", 4)));
  const ImageBuffer sixteen = decode(file(16, std::string_view("\x00\x01\x12\x34\x80\x00\xff\xff", 8)));
  const int ones[] = {0, 255, 0, 255}, twos[] = {0, 85, 170, 255}, eights[] = {0, 0x11, 0x80, 255},
            sixteens[] = {1, 0x1234, 0x8000, 0xffff};
  EXPECT_EQ(sixteen.format(), PixelFormat::kRgbPlanar16);
  for (int x = 0; x < 4; ++x) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(sample(one, c, x, 0), ones[x]);
      EXPECT_EQ(sample(two, c, x, 0), twos[x]);
      EXPECT_EQ(sample(eight, c, x, 0), eights[x]);
      EXPECT_EQ(sample(sixteen, c, x, 0), sixteens[x]);
    }
  }
}

TEST(Png, TakesAPaletteAndIgnoresItsTransparency) {
  const ImageBuffer image =
      decode(kPngSignature + png_header(2, 1, 8, 3) + png_chunk("PLTE", "\x01\x02\x03\xa0\xb0\xc0") +
             png_chunk("tRNS", std::string(2, '\0')) + png_data(std::string("\0\1\0", 3)) + kPngEnd);
  EXPECT_EQ(sample(image, 0, 0, 0), 0xa0);
  EXPECT_EQ(sample(image, 2, 0, 0), 0xc0);
  EXPECT_EQ(sample(image, 1, 1, 0), 0x02);
}

TEST(Png, DropsAlphaWithoutTouchingTheColours) {
  const ImageBuffer eight =
      decode(kPngSignature + png_header(1, 1, 8, 6) + png_data(std::string("\0\x10\x20\x30\0", 5)) + kPngEnd);
  const ImageBuffer sixteen =
      decode(kPngSignature + png_header(2, 1, 16, 6) +
             png_data(std::string("\0\1\2\3\4\5\6\0\0\7\x8\x9\xa\xb\xc\0\1", 17)) + kPngEnd);
  const ImageBuffer grey =
      decode(kPngSignature + png_header(1, 1, 16, 4) + png_data(std::string("\0\1\2\0\0", 5)) + kPngEnd);
  EXPECT_EQ(sample(eight, 0, 0, 0), 0x10);
  EXPECT_EQ(sample(eight, 2, 0, 0), 0x30);
  EXPECT_EQ(sample(sixteen, 2, 0, 0), 0x0506);
  EXPECT_EQ(sample(sixteen, 0, 1, 0), 0x0708);
  EXPECT_EQ(sample(sixteen, 2, 1, 0), 0x0b0c);
  EXPECT_EQ(sample(grey, 1, 0, 0), 0x0102);
}

TEST(Png, TakesInterlacedPictures) {
  for (const Size size : {Size{1, 1}, Size{3, 5}, Size{33, 17}}) {
    const ImageBuffer image = noise_picture(PixelFormat::kRgbPlanar8, size);
    EXPECT_EQ(largest_difference(decode(png_file(image.pixels(), true)).pixels(), image.pixels()), 0);
  }
}

TEST(Png, IgnoresGammaAndProfiles) {
  const ImageBuffer image = noise_picture(PixelFormat::kRgbPlanar8, {9, 9});
  const std::string gamma = png_chunk("gAMA", std::string("\0\0\xb1\x8f", 4));
  const std::string srgb = png_chunk("sRGB", std::string(1, '\0'));
  const std::string profile = png_chunk("iCCP", std::string("broken\0\0not deflated", 20));
  for (const std::string& chunk : {gamma, srgb, profile, gamma + srgb}) {
    EXPECT_EQ(largest_difference(decode(png_file(image.pixels(), false, chunk)).pixels(), image.pixels()), 0);
  }
}

TEST(Png, TakesOneLargeDataChunk) {
  std::string rows;
  for (int y = 0; y < 3000; ++y) rows += '\0' + std::string(3 * 2000, static_cast<char>(y));
  const std::string data = png_data(rows, 0);
  ASSERT_GT(data.size(), std::size_t{17} << 20);  // beyond the limit for texts and profiles
  const ImageBuffer back = decode(kPngSignature + png_header(2000, 3000, 8, 2) + data + kPngEnd);
  EXPECT_EQ(sample(back, 2, 1999, 2999), 2999 % 256);
}

TEST(Jpeg, ComesBackWithinAFewSteps) {
  const ImageBuffer image = smooth_picture(PixelFormat::kRgbPlanar8, {67, 45});
  for (const bool progressive : {false, true}) {
    const ImageBuffer back =
        decode(jpeg_file(image.pixels(), {.progressive = progressive, .sampling = 1, .quality = 100}));
    EXPECT_LE(largest_difference(image.pixels(), back.pixels()), 4);
  }
}

TEST(Jpeg, MakesGreyToRgb) {
  const ImageBuffer image = smooth_picture(PixelFormat::kRgbPlanar8, {31, 16});
  const ImageBuffer back = decode(jpeg_file(image.pixels(), {.components = 1, .quality = 100}));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sample(back, c, 20, 9), sample(image, 0, 20, 9), 2);
}

TEST(Jpeg, SkippedRowsAboveChangeNothingBelow) {
  const ImageBuffer image = noise_picture(PixelFormat::kRgbPlanar8, {61, 97});
  for (const bool progressive : {false, true}) {
    for (const int sampling : {1, 2}) {
      for (const int components : {1, 3}) {
        const std::string file = jpeg_file(
            image.pixels(),
            {.components = components, .progressive = progressive, .sampling = sampling, .quality = 90});
        const ImageBuffer whole = decode(file);
        for (int first = 0; first < 97; first += 3) {
          ImageBuffer part(PixelFormat::kRgbPlanar8, image.size());
          const int skipped =
              decode_still(std::as_bytes(std::span(file)), "test", part.pixels(), {first, first + 20});
          EXPECT_EQ(skipped, 97 - (std::min(97, first + 20) - first));
          const Size rows{61, std::min(97, first + 20) - first};
          ASSERT_EQ(largest_difference(part_of(std::as_const(part).pixels(), 0, first, rows),
                                       part_of(whole.pixels(), 0, first, rows)),
                    0)
              << first << progressive << sampling << components;
        }
      }
    }
  }
}

TEST(Tiff, ComesBackToTheBitInEveryLosslessKind) {
  const TemporaryFolder folder;
  for (const char* mode : {"wl", "wb", "w8"}) {  // both byte orders and BigTIFF
    for (const TiffKind& kind : kTiffKinds) {
      const ImageBuffer image =
          noise_picture(kind.bits == 16 ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8, {29, 23});
      write_tiff(folder / "a.tif", image.pixels(), kind, mode);
      const ImageBuffer back = read_still(folder / "a.tif");
      EXPECT_EQ(back.format(), image.format()) << kind.name;
      EXPECT_EQ(largest_difference(back.pixels(), image.pixels()), 0) << kind.name << mode;
    }
  }
}

TEST(Tiff, TakesGreyBothWaysRound) {
  const TemporaryFolder folder;
  const ImageBuffer image = noise_picture(PixelFormat::kRgbPlanar8, {16, 9});
  for (const bool white_is_zero : {false, true}) {
    write_tiff(
        folder / "a.tif", image.pixels(),
        {"grey", 8, 1, white_is_zero ? PHOTOMETRIC_MINISWHITE : PHOTOMETRIC_MINISBLACK, COMPRESSION_NONE});
    const ImageBuffer back = read_still(folder / "a.tif");
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(sample(back, c, 3, 4), white_is_zero ? 255 - sample(image, 0, 3, 4) : sample(image, 0, 3, 4));
    }
  }
}

TEST(Tiff, TakesBitsAndPalettes) {
  const TemporaryFolder folder;
  const ImageBuffer none(PixelFormat::kRgbPlanar8, {16, 1});
  const auto write = [&](int bits, int photometric, std::uint8_t first) {
    TIFF* tiff = TIFFOpen((folder / "a.tif").c_str(), "w");
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 16);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, photometric);
    std::vector<std::uint16_t> map(256);
    for (std::size_t i = 0; i < 256; ++i) map[i] = static_cast<std::uint16_t>(257 * (255 - i));
    if (photometric == PHOTOMETRIC_PALETTE)
      TIFFSetField(tiff, TIFFTAG_COLORMAP, map.data(), map.data(), map.data());
    std::uint8_t row[16] = {first};
    TIFFWriteScanline(tiff, row, 0, 0);
    TIFFClose(tiff);
    return read_still(folder / "a.tif");
  };
  const ImageBuffer bits = write(1, PHOTOMETRIC_MINISBLACK, 0b01000000);
  EXPECT_EQ(sample(bits, 0, 0, 0), 0);
  EXPECT_EQ(sample(bits, 2, 1, 0), 255);
  const ImageBuffer nibbles = write(4, PHOTOMETRIC_MINISBLACK, 0x3f);
  EXPECT_EQ(sample(nibbles, 0, 0, 0), 51);
  EXPECT_EQ(sample(nibbles, 0, 1, 0), 255);
  const ImageBuffer palette = write(8, PHOTOMETRIC_PALETTE, 10);
  EXPECT_EQ(sample(palette, 1, 0, 0), 245);
  EXPECT_EQ(sample(palette, 1, 1, 0), 255);
}

TEST(Stills, FillOnlyTheRowsAskedForAndStopBelowThem) {
  const TemporaryFolder folder;
  const ImageBuffer image = noise_picture(PixelFormat::kRgbPlanar8, {20, 50});
  write_png(folder / "a.png", image.pixels());
  write_tiff(folder / "a.tif", image.pixels(), {"rgb", 8, 3, PHOTOMETRIC_RGB, COMPRESSION_LZW});
  FileBytes memory;
  for (const char* name : {"a.png", "a.tif"}) {
    ImageBuffer part(PixelFormat::kRgbPlanar8, image.size());
    EXPECT_EQ(read_still_into(folder / name, part.pixels(), {10, 30}, memory), 20);
    const Image seen = std::as_const(part).pixels();
    EXPECT_EQ(largest_difference(part_of(seen, 0, 10, {20, 20}), part_of(image.pixels(), 0, 10, {20, 20})),
              0);
    EXPECT_EQ(sample(seen, 0, 5, 40), 0);
    EXPECT_EQ(read_still_into(folder / name, part.pixels(), {30, 10}, memory), 50);
  }
}

TEST(Stills, AreWidenedOrNarrowedIntoThePictureGiven) {
  const TemporaryFolder folder;
  const ImageBuffer narrow = noise_picture(PixelFormat::kRgbPlanar8, {20, 10});
  ImageBuffer wide(PixelFormat::kRgbPlanar16, {20, 10}), back(PixelFormat::kRgbPlanar8, {20, 10});
  FileBytes memory;
  write_png(folder / "a.png", narrow.pixels());
  read_still_into(folder / "a.png", wide.pixels(), {}, memory);
  EXPECT_EQ(sample(wide, 2, 19, 9), 257 * sample(narrow, 2, 19, 9));
  write_png(folder / "a.png", wide.pixels());
  read_still_into(folder / "a.png", back.pixels(), {}, memory);
  EXPECT_EQ(largest_difference(back.pixels(), narrow.pixels()), 0);
}

TEST(Stills, OfAnotherSizeThanExpectedAreRefused) {
  const TemporaryFolder folder;
  const ImageBuffer image = noise_picture(PixelFormat::kRgbPlanar8, {20, 10});
  write_png(folder / "a.png", image.pixels());
  ImageBuffer other(PixelFormat::kRgbPlanar8, {10, 20});
  FileBytes memory;
  EXPECT_THROW(read_still_into(folder / "a.png", other.pixels(), {}, memory), InputError);
}

}  // namespace
}  // namespace cupola
