// Pictures and files for tests, well made and badly.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/frame/image.h"
#include "tests/frame/temporary_folder.h"

namespace cupola {

// Every sample as a function of place and seed, all values occurring.
ImageBuffer noise_picture(PixelFormat format, Size size, std::uint32_t seed = 1);
// Smooth, as photographs are.
ImageBuffer smooth_picture(PixelFormat format, Size size);

// Sample `channel` (0 red, 1 green, 2 blue) of any format.
int sample(const Image& image, int channel, int x, int y);
inline int sample(const ImageBuffer& image, int channel, int x, int y) {
  return sample(image.pixels(), channel, x, y);
}
// The largest difference of two pictures of equal size and depth.
int largest_difference(const Image& a, const Image& b);

// PNG, chunk by chunk.
std::string png_chunk(std::string_view type, std::string_view data);
std::string png_header(std::uint32_t width, std::uint32_t height, int depth, int colour_type,
                       bool interlaced = false);
// IDAT of rows that begin with their filter's byte.
std::string png_data(std::string_view filtered_rows, int compression = 6);
extern const std::string kPngSignature;
extern const std::string kPngEnd;
// RGB, 8 bits.
std::string png_file(const Image& image, bool interlaced = false, std::string_view before_data = {});

struct JpegKind {
  int components = 3;  // 1 grey, 3 YCbCr, 4 CMYK
  bool ycck = false;
  bool progressive = false;
  int sampling = 2;  // of luma, both ways
  int quality = 95;
};
std::string jpeg_file(const Image& image, const JpegKind& kind = {});

struct TiffKind {
  const char* name;
  int bits;
  int samples;
  int photometric;
  int compression;
};
extern const std::vector<TiffKind> kTiffKinds;  // RGB, lossless
// `mode` as TIFFOpen has it.
void write_tiff(const std::filesystem::path& path, const Image& image, const TiffKind& kind,
                const char* mode = "w");

}  // namespace cupola
