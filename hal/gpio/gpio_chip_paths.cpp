// The kernel's GPIO chips.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstring>
#include <memory>

#include <dirent.h>

#include "hal/gpio/gpio_search.h"

namespace cupola {

std::vector<std::string> gpio_chip_paths() {
  constexpr std::string_view kPrefix = "gpiochip";
  std::vector<std::string> paths;
  struct Close {
    void operator()(DIR* folder) const { closedir(folder); }
  };
  const std::unique_ptr<DIR, Close> folder(opendir("/dev"));
  while (const dirent* entry = folder ? readdir(folder.get()) : nullptr) {
    if (std::string_view(entry->d_name).starts_with(kPrefix)) {
      paths.push_back(std::string("/dev/") + entry->d_name);
    }
  }
  std::sort(paths.begin(), paths.end(), [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  });
  return paths;
}

}  // namespace cupola
