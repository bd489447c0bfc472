// The header line of a YUV4MPEG2 file.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "pipeline/frame/image.h"
#include "pipeline/frame/yuv_to_rgb.h"

namespace cupola {

struct FrameRate {
  std::int64_t numerator = 0;    // frames
  std::int64_t denominator = 1;  // seconds; 0 frames: not known
};

// 59.94 is meant as 60000/1001.
FrameRate frame_rate(double frames_a_second);

struct Y4mHeader : PlanarVideo {
  FrameRate rate;
  std::size_t bytes = 0;  // of the line, its line feed included

  std::int64_t luma_bytes() const { return std::int64_t{size.width} * size.height * bytes_per_sample(); }
  std::int64_t chroma_bytes() const {  // one plane
    return colour ? std::int64_t{chroma_width()} * chroma_height() * bytes_per_sample() : 0;
  }
  std::int64_t frame_bytes() const { return luma_bytes() + 2 * chroma_bytes(); }
};

inline constexpr std::size_t kLongestY4mHeader = 1024;  // bytes

// `start` holds the file's first bytes, up to kLongestY4mHeader. Understood are progressive pictures with C
// tags 420jpeg, 420mpeg2, 420paldv, 420, 422, 444, mono, and those with p10, p12, p14, p16 (mono: 10, 12, 16)
// appended, XCOLORRANGE=FULL or LIMITED, LIMITED where nothing is said. Throws InputError for all others.
Y4mHeader parse_y4m_header(std::string_view start, const std::string& name);

}  // namespace cupola
