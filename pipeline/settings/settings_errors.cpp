// Sorting what is wrong.
// SPDX-License-Identifier: MIT
#include "pipeline/settings/settings_errors.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace cupola {

std::size_t SettingsErrors::begin_file(const std::string& name) {
  const auto found = std::find(files_.begin(), files_.end(), name);
  const auto place = static_cast<std::size_t>(found - files_.begin());
  if (found == files_.end()) files_.push_back(name);
  return place;
}

std::size_t SettingsErrors::add(Place place, std::string message) {
  entries_.push_back({place, std::move(message), false});
  return entries_.size() - 1;
}

std::vector<std::string> SettingsErrors::lines() const {
  std::vector<const Entry*> order;
  for (const Entry& entry : entries_) {
    if (!entry.withdrawn) order.push_back(&entry);
  }
  std::stable_sort(order.begin(), order.end(), [](const Entry* a, const Entry* b) {
    return std::tie(a->place.file, a->place.line) < std::tie(b->place.file, b->place.line);
  });
  std::vector<std::string> lines;
  for (const Entry* entry : order) {
    if (std::find(lines.begin(), lines.end(), entry->message) == lines.end()) lines.push_back(entry->message);
  }
  return lines;
}

}  // namespace cupola
