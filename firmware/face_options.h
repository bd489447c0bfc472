// The options that say where the faces come from, for commands that work without a show.
// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "firmware/show.h"

namespace cupola {

class FaceOptions {
 public:
  // `faces_name` is the option that names the cells of the atlas.
  explicit FaceOptions(CLI::App& options, std::string faces_name = "--faces");

  bool given() const { return !views_.empty() || !atlas_.empty() || !world_.empty(); }
  // What was asked for, as the one cue of a show. Throws InputError: two kinds at once, a view twice, unknown
  // or missing.
  Cue cue(const Rig& rig) const;

 private:
  Cue from_views(const Rig& rig) const;

  std::vector<std::string> views_;
  std::string atlas_;
  std::string layout_;
  std::string faces_name_;
  std::string faces_;
  std::string world_;
  int face_size_ = 1024;
};

}  // namespace cupola
