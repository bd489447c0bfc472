// Where named configuration files are: beside the file that names them, then installed, then in the source
// tree.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string_view>

namespace cupola {

// `name` with or without ".toml". Looked for in `directory`, then in `room` ("lenses", "rigs", ...) of the
// installed and of the source tree's config folder. Empty when there is none.
std::filesystem::path find_config(const std::filesystem::path& name, const std::filesystem::path& directory,
                                  std::string_view room);

}  // namespace cupola
