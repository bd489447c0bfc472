// Y4M videos as planar RGB, any frame at any time.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "pipeline/frame/file_bytes.h"
#include "pipeline/frame/image.h"
#include "pipeline/frame/row_range.h"
#include "pipeline/frame/y4m_header.h"
#include "pipeline/frame/yuv_to_rgb.h"

namespace cupola {

// YCbCr is taken as BT.709 whatever the size; converted as YuvToRgb does. One thread at a time.
class Y4mReader {
 public:
  // Throws InputError: no Y4M, a kind not understood, an incomplete last frame.
  explicit Y4mReader(const std::filesystem::path& path);

  const Y4mHeader& header() const { return header_; }
  Size size() const { return header_.size; }
  PixelFormat format() const {
    return header_.bits > 8 ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8;
  }
  std::int64_t frames() const { return frames_; }

  // Fills the rows `rows` of `into`, which has the video's size and any planar format; reads no others.
  // Throws InputError. Does not allocate.
  void read(std::int64_t frame, const MutableImage& into, RowRange rows = {});

 private:
  RegularFile file_;
  std::string name_;
  Y4mHeader header_;
  std::int64_t frames_ = 0;
  std::vector<std::byte> luma_;       // the rows asked for
  std::vector<std::byte> chroma_[2];  // those they need
  std::optional<YuvToRgb> to_rgb_;
};

}  // namespace cupola
