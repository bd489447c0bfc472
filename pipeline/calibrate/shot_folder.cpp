// Listing what is there, strictly.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/shot_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "pipeline/frame/error.h"
#include "pipeline/settings/settings.h"

namespace cupola {
namespace {

std::vector<std::filesystem::path> sorted(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> entries;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    if (!entry->path().filename().string().starts_with('.')) entries.push_back(entry->path());
  }
  if (error)
    throw InputError(fmt::format("{}: expected a folder of pictures, VIEW/SHOT.png: {}", folder.string(),
                                 error.message()));
  std::sort(entries.begin(), entries.end());
  return entries;
}

}  // namespace

ShotFolder list_shots(const std::filesystem::path& folder, std::span<const std::string> views) {
  struct Found {
    int camera;
    std::string shot;
    std::filesystem::path file;
  };
  std::vector<Found> found;
  for (const std::filesystem::path& inside : sorted(folder)) {
    const std::string name = inside.filename().string();
    const auto view = std::find(views.begin(), views.end(), name);
    if (view == views.end() || !std::filesystem::is_directory(inside)) {
      const std::vector<std::string_view> names(views.begin(), views.end());
      const std::string_view nearest = nearest_name(name, names);
      throw InputError(fmt::format(
          "{}: expected folders named by the rig's views ({}){}", inside.string(), fmt::join(views, ", "),
          nearest.empty() || nearest == name ? "" : fmt::format("; did you mean {}?", nearest)));
    }
    std::map<std::string, std::filesystem::path> shots;
    for (const std::filesystem::path& file : sorted(inside)) {
      const auto [before, first] = shots.try_emplace(file.stem().string(), file);
      if (!first)
        throw InputError(fmt::format("{}: expected one picture a shot, but there is {} already",
                                     file.string(), before->second.filename().string()));
    }
    for (const auto& [shot, file] : shots)
      found.push_back({static_cast<int>(view - views.begin()), shot, file});
  }
  if (found.empty())
    throw InputError(fmt::format("{}: expected pictures, as in {}/{}/0001.png", folder.string(),
                                 folder.string(), views.empty() ? "front" : views.front()));
  ShotFolder result;
  std::map<std::string, int> places;
  for (const Found& picture : found) places[picture.shot] = 0;
  for (auto& [shot, place] : places) {
    place = static_cast<int>(result.shots.size());
    result.shots.push_back(shot);
  }
  for (const Found& picture : found)
    result.pictures.push_back({picture.camera, places[picture.shot], picture.file});
  std::stable_sort(result.pictures.begin(), result.pictures.end(),
                   [](const ShotPicture& a, const ShotPicture& b) { return a.camera < b.camera; });
  return result;
}

}  // namespace cupola
