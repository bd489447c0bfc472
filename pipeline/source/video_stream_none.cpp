// Built without FFmpeg's libraries: videos are refused by name.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "pipeline/frame/error.h"
#include "pipeline/source/video_stream.h"

namespace cupola {

std::unique_ptr<PictureStream> open_video(const std::filesystem::path& path) {
  throw InputError(fmt::format("{}: this build plays no video but Y4M (CUPOLA_VIDEO is off)", path.string()));
}

}  // namespace cupola
