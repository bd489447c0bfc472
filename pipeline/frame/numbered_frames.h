// Frames written as numbered files, named as domemasters are.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "pipeline/frame/image.h"
#include "pipeline/frame/still.h"

namespace cupola {

// Frames count from 0, files from 1: frame 0 is FOLDER/NAME_000001.png (or .exr). write() may be called from
// several threads at once for different frames.
class NumberedFrames {
 public:
  // Makes the folder, and those above it, where missing; throws Failure.
  NumberedFrames(std::filesystem::path folder, std::string name, StillFormat format = StillFormat::kPng);

  std::filesystem::path path_of(std::int64_t frame) const;
  void write(std::int64_t frame, const Image& image) const;  // throws Failure

 private:
  std::filesystem::path folder_;
  std::string name_;
  StillFormat format_;
};

}  // namespace cupola
