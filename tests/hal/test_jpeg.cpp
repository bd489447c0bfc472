// libjpeg's raw interface, the other way round.
// SPDX-License-Identifier: MIT
#include "tests/hal/test_jpeg.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>

#include <jpeglib.h>

namespace cupola::test {
namespace {

// Without the segments of type `marker`, up to the scan.
std::vector<std::uint8_t> without_segments(const std::vector<std::uint8_t>& jpeg, std::uint8_t marker) {
  std::vector<std::uint8_t> kept(jpeg.begin(), jpeg.begin() + 2);
  std::size_t at = 2;
  while (jpeg[at + 1] != 0xda) {
    const std::size_t length = 2 + static_cast<std::size_t>(jpeg[at + 2] * 256 + jpeg[at + 3]);
    const auto from = jpeg.begin() + static_cast<std::ptrdiff_t>(at);
    if (jpeg[at + 1] != marker) kept.insert(kept.end(), from, from + static_cast<std::ptrdiff_t>(length));
    at += length;
  }
  kept.insert(kept.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at), jpeg.end());
  return kept;
}

}  // namespace

std::vector<std::uint8_t> make_jpeg(const JpegMaking& making, const JpegSample& sample) {
  jpeg_compress_struct compress{};
  jpeg_error_mgr errors{};
  compress.err = jpeg_std_error(&errors);
  jpeg_create_compress(&compress);
  unsigned char* memory = nullptr;
  unsigned long bytes = 0;
  jpeg_mem_dest(&compress, &memory, &bytes);
  compress.image_width = static_cast<JDIMENSION>(making.width);
  compress.image_height = static_cast<JDIMENSION>(making.height);
  compress.input_components = making.components;
  compress.in_color_space = making.components == 1 ? JCS_GRAYSCALE : making.rgb ? JCS_RGB : JCS_YCbCr;
  jpeg_set_defaults(&compress);
  jpeg_set_colorspace(&compress, compress.in_color_space);
  jpeg_set_quality(&compress, making.quality, TRUE);
  compress.raw_data_in = TRUE;
  if (making.components == 3 && !making.rgb) {
    compress.comp_info[0].h_samp_factor = making.across;
    compress.comp_info[0].v_samp_factor = making.down;
  }
  if (making.progressive) jpeg_simple_progression(&compress);
  jpeg_start_compress(&compress, TRUE);
  const int rows = compress.max_v_samp_factor * DCTSIZE;
  for (int y = 0; y < making.height; y += rows) {
    std::array<std::vector<JSAMPLE>, 3> samples;
    std::array<std::array<JSAMPROW, 4 * DCTSIZE>, 3> pointers{};
    std::array<JSAMPARRAY, 3> components{};
    for (int c = 0; c < making.components; ++c) {
      const auto at = static_cast<std::size_t>(c);
      const jpeg_component_info& info = compress.comp_info[c];
      const int width = static_cast<int>(info.width_in_blocks) * DCTSIZE;
      const int height = info.v_samp_factor * DCTSIZE;
      const int first = y / compress.max_v_samp_factor * info.v_samp_factor;
      samples[at].resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
      for (int row = 0; row < height; ++row) {
        JSAMPLE* to = samples[at].data() + row * width;
        pointers[at][static_cast<std::size_t>(row)] = to;
        for (int x = 0; x < width; ++x) {
          to[x] = static_cast<JSAMPLE>(std::clamp(sample(c, x, first + row), 0, 255));
        }
      }
      components[at] = pointers[at].data();
    }
    jpeg_write_raw_data(&compress, components.data(), static_cast<JDIMENSION>(rows));
  }
  jpeg_finish_compress(&compress);
  jpeg_destroy_compress(&compress);
  std::vector<std::uint8_t> jpeg(memory, memory + bytes);
  std::free(memory);  // libjpeg's malloc
  return making.huffman_tables ? jpeg : without_segments(jpeg, 0xc4);
}

}  // namespace cupola::test
