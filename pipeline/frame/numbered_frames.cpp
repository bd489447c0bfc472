// Numbered files in a folder.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/numbered_frames.h"

#include <fmt/format.h>

#include <utility>

#include "pipeline/frame/error.h"

namespace cupola {

NumberedFrames::NumberedFrames(std::filesystem::path folder, std::string name, StillFormat format)
    : folder_(std::move(folder)), name_(std::move(name)), format_(format) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (!std::filesystem::is_directory(folder_)) {
    throw Failure(fmt::format("{}: cannot be made a folder: {}", folder_.string(),
                              error ? error.message() : "a file has this name"));
  }
}

std::filesystem::path NumberedFrames::path_of(std::int64_t frame) const {
  return folder_ / fmt::format("{}_{:06}.{}", name_, frame + 1, format_ == StillFormat::kExr ? "exr" : "png");
}

void NumberedFrames::write(std::int64_t frame, const Image& image) const {
  write_still(path_of(frame), image, format_);
}

}  // namespace cupola
