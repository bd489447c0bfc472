// JPEG through libjpeg-turbo. Errors come by longjmp, so between the guard and the library's calls there are
// no objects with destructors.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/jpeg_writer.h"

#include <cassert>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>

#include <jpeglib.h>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

struct Encoder {
  jpeg_compress_struct compress{};
  jpeg_error_mgr errors{};
  std::jmp_buf out{};
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
};

bool encode(Encoder& encoder, const Image& image, int quality) {
  jpeg_compress_struct& compress = encoder.compress;
  if (setjmp(encoder.out) != 0) return false;
  jpeg_create_compress(&compress);
  compress.client_data = &encoder;
  jpeg_mem_dest(&compress, &encoder.bytes, &encoder.size);
  compress.image_width = static_cast<JDIMENSION>(image.size.width);
  compress.image_height = static_cast<JDIMENSION>(image.size.height);
  const bool words = image.format == PixelFormat::kXrgb8888;
  compress.input_components = words ? 4 : 3;
  compress.in_color_space = words ? JCS_EXT_BGRX : JCS_RGB;
  jpeg_set_defaults(&compress);
  jpeg_set_quality(&compress, quality, TRUE);
  jpeg_start_compress(&compress, TRUE);
  for (int y = 0; y < image.size.height; ++y) {
    // The library does not write to rows, though it does not say so.
    auto* row = const_cast<unsigned char*>(reinterpret_cast<const unsigned char*>(image.planes[0].row(y)));
    jpeg_write_scanlines(&compress, &row, 1);
  }
  jpeg_finish_compress(&compress);
  return true;
}

}  // namespace

std::string encode_jpeg(const Image& image, int quality) {
  assert(image.format == PixelFormat::kXrgb8888 || image.format == PixelFormat::kRgb8);
  Encoder encoder;
  encoder.compress.err = jpeg_std_error(&encoder.errors);
  encoder.compress.client_data = &encoder;
  encoder.errors.error_exit = [](j_common_ptr common) {
    std::longjmp(static_cast<Encoder*>(common->client_data)->out, 1);
  };
  encoder.errors.output_message = [](j_common_ptr) {};
  const bool done = encode(encoder, image, quality);
  jpeg_destroy_compress(&encoder.compress);
  std::string bytes;
  if (done) bytes.assign(reinterpret_cast<const char*>(encoder.bytes), encoder.size);
  std::free(encoder.bytes);
  if (!done) throw Failure("a JPEG could not be made: there is not enough memory");
  return bytes;
}

}  // namespace cupola
