// Frames as a Y4M video, into a file or down a pipe.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/image.h"
#include "pipeline/frame/y4m_header.h"

namespace cupola {

// 4:4:4 of 8 or 10 bits, BT.709, limited range; 16-bit frames are rounded once. The path "-" is standard
// output, where a program must ignore SIGPIPE for a closed pipe to be a Failure. A file appears under its
// name only when finish() returns. Every member throws Failure.
class Y4mWriter {
 public:
  Y4mWriter(const std::filesystem::path& path, Size size, FrameRate rate, int bits = 8);

  void write(const Image& image);  // of that size, in any of our formats
  void finish();                   // once, as the last call

 private:
  template <class Out>
  void write_row(int y, bool deep);

  AtomicFile file_;
  Size size_;
  int bits_;
  ImageBuffer row_;  // planar, of the depth of the frame at hand
  std::vector<std::byte> planes_;
};

}  // namespace cupola
