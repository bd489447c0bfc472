// Compressed videos as picture streams, any frame at any time, through FFmpeg's libraries.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>

#include "pipeline/source/picture_stream.h"

namespace cupola {

// The file's first video, frame by frame in the order of their times, however these are spaced. To open it
// all of the file is read once, for the times of its frames. read() gives the same bits whatever was read
// before: it decodes on, or from the last key frame before. Luma and chroma planes of 8 to 16 bits and grey
// are taken, and RGB of 8; everything comes out as 8 bits, converted as YuvToRgb does, with the
// stream's matrix and range (BT.709, for JPEG BT.601, where it names none). Nothing but the file itself is
// opened, whatever it refers to. Throws InputError, also where this build has no video.
std::unique_ptr<PictureStream> open_video(const std::filesystem::path& path);

}  // namespace cupola
