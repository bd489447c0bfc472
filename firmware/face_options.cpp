// --view, --atlas and --world.
// SPDX-License-Identifier: MIT
#include "firmware/face_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/frame/error.h"
#include "pipeline/settings/settings.h"
#include "pipeline/source/world.h"

namespace cupola {
namespace {

std::vector<std::string_view> view_names(const Rig& rig) {
  std::vector<std::string_view> names;
  for (const View& view : rig.views) names.push_back(view.name);
  return names;
}

std::string suggestion(std::string_view word, std::span<const std::string_view> names) {
  const std::string_view nearest = nearest_name(word, names);
  return nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest);
}

}  // namespace

FaceOptions::FaceOptions(CLI::App& options, std::string faces_name) : faces_name_(std::move(faces_name)) {
  options.add_option("--view", views_, "A view's picture; once for each view of the rig")
      ->allow_extra_args(false)
      ->type_name("NAME=IMG");
  options.add_option("--atlas", atlas_, "One picture with the faces of all views")->type_name("IMG");
  options.add_option("--layout", layout_, "Columns and rows of the atlas, like 3x2")->type_name("CxR");
  options.add_option(faces_name_, faces_, "The faces in the atlas, row by row")->type_name("front,right,...");
  options.add_option("--world", world_, "A generated world instead of pictures, like demo")
      ->type_name("NAME");
  options.add_option("--face-size", face_size_, "Sides of the generated world's faces, texels")
      ->check(CLI::Range(1, 16384))
      ->type_name("N");
}

Cue FaceOptions::cue(const Rig& rig) const {
  const int kinds = (views_.empty() ? 0 : 1) + (atlas_.empty() ? 0 : 1) + (world_.empty() ? 0 : 1);
  if (kinds != 1) throw InputError("expected either --view for each view, or --atlas, or --world");
  if (!views_.empty()) return from_views(rig);
  Cue cue;
  if (!world_.empty()) {
    const auto names = world_names();
    if (std::find(names.begin(), names.end(), world_) == names.end()) {
      throw InputError(fmt::format("--world {}: no such world{}", world_, suggestion(world_, names)));
    }
    cue.source = CueSource::kGenerated;
    cue.name = cue.world = world_;
    cue.face_size = {face_size_, face_size_};
    return cue;
  }
  if (layout_.empty() || faces_.empty())
    throw InputError("--atlas: expected --layout and " + faces_name_ + " with it");
  cue.source = CueSource::kAtlas;
  cue.name = "atlas";
  cue.file = atlas_;
  std::vector<std::string> faces(1);
  for (const char c : faces_) {
    if (c == ',') {
      faces.emplace_back();
    } else {
      faces.back() += c;
    }
  }
  try {
    cue.layout = parse_layout(layout_, std::move(faces));
  } catch (const InputError& error) {
    throw InputError(fmt::format("--layout {}: {}", layout_, error.what()));
  }
  return cue;
}

Cue FaceOptions::from_views(const Rig& rig) const {
  const std::vector<std::string_view> names = view_names(rig);
  Cue cue;
  cue.source = CueSource::kStills;
  cue.name = "views";
  cue.files.resize(names.size());
  for (const std::string& given : views_) {
    const std::size_t equals = given.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == given.size()) {
      throw InputError(fmt::format("--view {}: expected NAME=IMG", given));
    }
    const std::string name = given.substr(0, equals);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      throw InputError(fmt::format("--view {}: {} has no view {}{}", given, rig.file.string(), name,
                                   suggestion(name, names)));
    }
    std::filesystem::path& file = cue.files[static_cast<std::size_t>(found - names.begin())];
    if (!file.empty()) throw InputError(fmt::format("--view {}: view {} was given before", given, name));
    file = given.substr(equals + 1);
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (cue.files[i].empty()) {
      throw InputError(fmt::format("--view {}=IMG: missing; {} has this view", names[i], rig.file.string()));
    }
  }
  return cue;
}

}  // namespace cupola
