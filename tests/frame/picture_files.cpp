// Making pictures and files for tests.
// SPDX-License-Identifier: MIT
#include "tests/frame/picture_files.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include <jpeglib.h>
#include <tiffio.h>
#include <unistd.h>
#include <zlib.h>

namespace cupola {

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "cupola-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) std::abort();
  path_ = name;
}
TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}
std::vector<std::string> TemporaryFolder::names() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(path_))
    names.push_back(entry.path().filename());
  std::ranges::sort(names);
  return names;
}

void write_text(const std::filesystem::path& path, std::string_view bytes) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

namespace {

void put_sample(const MutableImage& image, int channel, int x, int y, int value) {
  ImageBuffer one(sample_bytes(image.format) == 2 ? PixelFormat::kRgb16 : PixelFormat::kRgb8, {1, 1});
  const MutableImage pixel = part_of(image, x, y, {1, 1});
  convert(as_const(pixel), one.pixels());
  if (sample_bytes(image.format) == 2) {
    one.pixels().samples<std::uint16_t>(0, 0)[channel] = static_cast<std::uint16_t>(value);
  } else {
    one.pixels().samples<std::uint8_t>(0, 0)[channel] = static_cast<std::uint8_t>(value);
  }
  convert(as_const(one.pixels()), pixel);
}

}  // namespace

ImageBuffer noise_picture(PixelFormat format, Size size, std::uint32_t seed) {
  ImageBuffer image(format, size);
  std::uint32_t state = seed * 2654435761U + 12345U;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        state = state * 1664525U + 1013904223U;
        put_sample(image.pixels(), c, x, y, static_cast<int>(state >> (sample_bytes(format) == 2 ? 16 : 24)));
      }
    }
  }
  return image;
}

ImageBuffer smooth_picture(PixelFormat format, Size size) {
  ImageBuffer image(format, size);
  const double most = sample_bytes(format) == 2 ? 65'535.0 : 255.0;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double value = 0.5 + 0.4 * std::sin(0.05 * x * (c + 1) + 0.07 * y + c);
        put_sample(image.pixels(), c, x, y, static_cast<int>(std::lround(most * value)));
      }
    }
  }
  return image;
}

int sample(const Image& image, int channel, int x, int y) {
  ImageBuffer one(sample_bytes(image.format) == 2 ? PixelFormat::kRgb16 : PixelFormat::kRgb8, {1, 1});
  convert(part_of(image, x, y, {1, 1}), one.pixels());
  const Image pixel = as_const(one.pixels());
  return sample_bytes(image.format) == 2 ? pixel.samples<std::uint16_t>(0, 0)[channel]
                                         : pixel.samples<std::uint8_t>(0, 0)[channel];
}

int largest_difference(const Image& a, const Image& b) {
  int largest = 0;
  for (int y = 0; y < a.size.height; ++y)
    for (int x = 0; x < a.size.width; ++x)
      for (int c = 0; c < 3; ++c)
        largest = std::max(largest, std::abs(sample(a, c, x, y) - sample(b, c, x, y)));
  return largest;
}

namespace {

std::string big_endian(std::uint32_t word) {
  return {static_cast<char>(word >> 24), static_cast<char>(word >> 16), static_cast<char>(word >> 8),
          static_cast<char>(word)};
}

}  // namespace

const std::string kPngSignature = "\x89PNG\r\n\x1a\n";
const std::string kPngEnd = png_chunk("IEND", "");

std::string png_chunk(std::string_view type, std::string_view data) {
  const std::string checked = std::string(type) + std::string(data);
  const auto sum =
      ::crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()));
  return big_endian(static_cast<std::uint32_t>(data.size())) + checked +
         big_endian(static_cast<std::uint32_t>(sum));
}

std::string png_header(std::uint32_t width, std::uint32_t height, int depth, int colour_type,
                       bool interlaced) {
  return png_chunk("IHDR", big_endian(width) + big_endian(height) + static_cast<char>(depth) +
                               static_cast<char>(colour_type) + std::string(2, '\0') +
                               (interlaced ? '\1' : '\0'));
}

std::string png_data(std::string_view filtered_rows, int compression) {
  uLongf length = ::compressBound(filtered_rows.size());
  std::string packed(length, '\0');
  ::compress2(reinterpret_cast<Bytef*>(packed.data()), &length,
              reinterpret_cast<const Bytef*>(filtered_rows.data()), filtered_rows.size(), compression);
  packed.resize(length);
  return png_chunk("IDAT", packed);
}

std::string png_file(const Image& image, bool interlaced, std::string_view before_data) {
  struct Pass {
    int x, y, step_x, step_y;
  };
  const std::vector<Pass> adam7 = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                                   {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
  std::string rows;
  for (const Pass& pass : interlaced ? adam7 : std::vector<Pass>{{0, 0, 1, 1}}) {
    if (pass.x >= image.size.width) continue;
    for (int y = pass.y; y < image.size.height; y += pass.step_y) {
      rows += '\0';
      for (int x = pass.x; x < image.size.width; x += pass.step_x)
        for (int c = 0; c < 3; ++c) rows += static_cast<char>(sample(image, c, x, y));
    }
  }
  return kPngSignature +
         png_header(static_cast<std::uint32_t>(image.size.width),
                    static_cast<std::uint32_t>(image.size.height), 8, 2, interlaced) +
         std::string(before_data) + png_data(rows) + kPngEnd;
}

std::string jpeg_file(const Image& image, const JpegKind& kind) {
  jpeg_compress_struct compress{};
  jpeg_error_mgr errors{};
  compress.err = jpeg_std_error(&errors);
  jpeg_create_compress(&compress);
  unsigned char* memory = nullptr;
  unsigned long length = 0;
  jpeg_mem_dest(&compress, &memory, &length);
  compress.image_width = static_cast<JDIMENSION>(image.size.width);
  compress.image_height = static_cast<JDIMENSION>(image.size.height);
  compress.input_components = kind.components;
  compress.in_color_space = kind.components == 1 ? JCS_GRAYSCALE : kind.components == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&compress);
  if (kind.ycck) jpeg_set_colorspace(&compress, JCS_YCCK);
  jpeg_set_quality(&compress, kind.quality, TRUE);
  compress.comp_info[0].h_samp_factor = compress.comp_info[0].v_samp_factor =
      kind.components == 1 ? 1 : kind.sampling;
  if (kind.progressive) jpeg_simple_progression(&compress);
  jpeg_start_compress(&compress, TRUE);
  std::vector<unsigned char> row(static_cast<std::size_t>(image.size.width) * 4);
  for (int y = 0; y < image.size.height; ++y) {
    for (int x = 0; x < image.size.width; ++x) {
      for (int c = 0; c < kind.components; ++c) {
        row[static_cast<std::size_t>(x * kind.components + c)] =
            static_cast<unsigned char>(sample(image, c % 3, x, y));
      }
    }
    unsigned char* pointer = row.data();
    jpeg_write_scanlines(&compress, &pointer, 1);
  }
  jpeg_finish_compress(&compress);
  std::string file(reinterpret_cast<const char*>(memory), length);
  jpeg_destroy_compress(&compress);
  std::free(memory);
  return file;
}

const std::vector<TiffKind> kTiffKinds = {{"rgb", 8, 3, PHOTOMETRIC_RGB, COMPRESSION_NONE},
                                          {"deep", 16, 3, PHOTOMETRIC_RGB, COMPRESSION_LZW},
                                          {"alpha", 8, 4, PHOTOMETRIC_RGB, COMPRESSION_ADOBE_DEFLATE},
                                          {"deep alpha", 16, 4, PHOTOMETRIC_RGB, COMPRESSION_PACKBITS}};

void write_tiff(const std::filesystem::path& path, const Image& image, const TiffKind& kind,
                const char* mode) {
  TIFF* tiff = TIFFOpen(path.c_str(), mode);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, image.size.width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, image.size.height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kind.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, kind.samples);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, kind.photometric);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, kind.compression);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 7);
  std::vector<std::uint16_t> row(static_cast<std::size_t>(image.size.width) * kind.samples);
  for (int y = 0; y < image.size.height; ++y) {
    for (int x = 0; x < image.size.width; ++x) {
      for (int c = 0; c < kind.samples; ++c) {
        const auto at = static_cast<std::size_t>(x * kind.samples + c);
        const int value = c < 3 ? sample(image, c, x, y) : 0;
        if (kind.bits == 16) {
          row[at] = static_cast<std::uint16_t>(value);
        } else {
          reinterpret_cast<std::uint8_t*>(row.data())[at] = static_cast<std::uint8_t>(value);
        }
      }
    }
    TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(y), 0);
  }
  TIFFClose(tiff);
}

}  // namespace cupola
