// A show: what is played on a rig, cue after cue, read from one TOML file.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/rig_devices.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/source/face_source.h"
#include "pipeline/source/file_source.h"
#include "pipeline/warp/frame_warp.h"

namespace cupola {

enum class CueSource : std::uint8_t { kStills, kSequence, kAtlas, kGenerated, kTestPattern, kLive };

struct Cue {
  std::string name;
  CueSource source = CueSource::kGenerated;
  std::string file;                          // kStills, kSequence, kAtlas: a path or pattern
  std::vector<std::filesystem::path> files;  // kStills: one a view, instead of `file`
  AtlasLayout layout;                        // kAtlas
  std::string world;                         // kGenerated, kTestPattern
  Size face_size{1024, 1024};
  double rate = 60.0;  // frames a second
  std::optional<double> duration_s;
  SequencePart part;  // file numbers, or frames of a generated world
  bool loop = false;
  std::optional<Method> compare;    // the left half of the frame is made by this method
  std::optional<std::size_t> then;  // the next cue's place; none: the show stops
};

struct Show {
  std::string name;  // for the files it is rendered to
  Rig rig;
  RigDevices devices;     // of the same file
  std::vector<Cue> cues;  // at least one; a live one is alone
  bool live() const { return cues.front().source == CueSource::kLive; }
};

// `file` may be the name of a show in config/shows. Overrides that begin with "rig." go to the rig's file,
// the others to the show's; `rig`, unless empty, replaces the show's own. Throws InputError; when `errors` is
// given they are gathered there instead, as many as can be found, and the show is whole only when it stays
// empty.
Show load_show(const std::filesystem::path& file, std::span<const std::string> overrides,
               const std::filesystem::path& rig = {}, std::vector<std::string>* errors = nullptr);

// The rig file of that path, or of that name in config/rigs.
Rig load_named_rig(const std::filesystem::path& file, std::span<const std::string> overrides);

// Opens what the cue shows; throws InputError. `pool` is borrowed for the source's life.
std::unique_ptr<FaceSource> open_source(const Cue& cue, const Rig& rig, WorkerPool& pool);

// Gives the rig's views the sizes of the cue's faces; throws InputError where the rig demands others. Faces
// of 16 bits get the precise table: eight-bit weights would waste their depth.
void fit_faces(Rig& rig, const Cue& cue, const FaceSource& source);

// "3x2" and the names of its cells, row by row.
AtlasLayout parse_layout(const std::string& columns_and_rows, std::vector<std::string> faces);

}  // namespace cupola
