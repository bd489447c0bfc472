// JPEG pictures made of planes, for tests of what reads them.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace cupola::test {

struct JpegMaking {
  int width = 64;
  int height = 48;
  int components = 3;  // or 1
  int across = 2;      // luma samples to one of chroma
  int down = 2;
  int quality = 100;
  bool rgb = false;  // three channels of RGB instead
  bool progressive = false;
  bool huffman_tables = true;  // false: left out, as UVC cameras do
};

// Of component c at its own sample (x, y): 0 to 255.
using JpegSample = std::function<int(int c, int x, int y)>;
std::vector<std::uint8_t> make_jpeg(const JpegMaking& making, const JpegSample& sample);

}  // namespace cupola::test
