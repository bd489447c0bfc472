// Finding configuration files whatever the current folder is.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/config_path.h"

namespace cupola {

std::filesystem::path find_config(const std::filesystem::path& name, const std::filesystem::path& directory,
                                  std::string_view room) {
  std::filesystem::path with_ending = name;
  with_ending += ".toml";
  for (const std::filesystem::path& folder :
       {directory, std::filesystem::path(CUPOLA_INSTALLED_CONFIG) / room,
        std::filesystem::path(CUPOLA_SOURCE_CONFIG) / room}) {
    for (const std::filesystem::path& candidate : {folder / name, folder / with_ending}) {
      std::error_code ignored;
      if (std::filesystem::is_regular_file(candidate, ignored)) return candidate;
    }
  }
  return {};
}

}  // namespace cupola
