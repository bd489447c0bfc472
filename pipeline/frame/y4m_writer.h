// Frames as a Y4M video, into a file or down a pipe.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/image.h"
#include "pipeline/frame/y4m_header.h"

namespace cupola {

// 8-bit 4:4:4, BT.709, limited range; 16-bit frames are rounded once. The path "-" is standard output, where
// a program must ignore SIGPIPE for a closed pipe to be a Failure. A file appears under its name only when
// finish() returns. Every member throws Failure.
class Y4mWriter {
 public:
  Y4mWriter(const std::filesystem::path& path, Size size, FrameRate rate);

  void write(const Image& image);  // of that size, in any of our formats
  void finish();                   // once, as the last call

 private:
  AtomicFile file_;
  Size size_;
  ImageBuffer row_;  // planar, of the depth of the frame at hand
  std::vector<std::byte> planes_;
};

}  // namespace cupola
