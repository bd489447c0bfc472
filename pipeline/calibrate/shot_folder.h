// The folder of pictures to calibrate from: DIR/VIEW/SHOT.png, a shot being the same moment on all cameras.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace cupola {

struct ShotPicture {
  int camera = 0;  // which of the rig's views
  int shot = 0;    // which of ShotFolder::shots
  std::filesystem::path file;
};

struct ShotFolder {
  std::vector<std::string> shots;     // names, without the pictures' endings, sorted
  std::vector<ShotPicture> pictures;  // by camera, then by shot
};

// Names that begin with a dot are left out. Throws InputError: no folder, no pictures, a folder that is no
// view's, something beside the folders, two pictures of one shot.
ShotFolder list_shots(const std::filesystem::path& folder, std::span<const std::string> views);

}  // namespace cupola
